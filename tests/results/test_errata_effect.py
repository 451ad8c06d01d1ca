from __future__ import annotations

from dataclasses import replace

from eai.abilities.record import ErrataUse, Record
from eai.results.coverage import errata_effect
from results.verdicts import SUCCEEDED, record

OUT = replace(SUCCEEDED, excluded="its goal holds from the beginning")


def used(task_id: str, *entries: str, excluded: bool = False, version: str = "3") -> Record:
    return replace(record(task_id, OUT if excluded else SUCCEEDED), errata=ErrataUse(version, entries))


def test_without_errata_there_is_no_effect() -> None:
    assert errata_effect([]) is None
    assert errata_effect([record("a", SUCCEEDED), record("b", OUT)]) is None


def test_what_errata_left_out_and_corrected_is_told_apart_from_what_they_are_not_about() -> None:
    records = [
        used("a"),
        used("b", "goal"),
        used("c", "scene", "goal", excluded=True),
        used("d", excluded=True),  # for a reason of its own
        record("e", SUCCEEDED),
    ]
    effect = errata_effect(records)
    assert effect is not None
    assert effect.to_json() == {
        "version": "3",
        "tasks": 5,
        "scored": 3,
        "left_out": ["c"],
        "corrected": ["b"],
    }
    assert effect.remark == (
        "Errata 3: of 5 tasks 1 left out, 1 corrected, 1 not scored for other reasons; 3 scored. "
        "--errata none takes the data as published."
    )


def test_several_versions_are_all_named_once() -> None:
    effect = errata_effect([used("a", version="2"), used("b", version="3"), used("c", version="2")])
    assert effect is not None
    assert effect.version == "2, 3"
