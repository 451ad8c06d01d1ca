from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import ConfusionCounts, ErrorReport, PlanVerdict
from eai.agents.verdict import EpisodeVerdict
from eai.base.errors import InputError
from eai.results.codec import record_to_json
from eai.results.record import Record
from eai.results.records import read_records
from eai.tasks.share import Share, TalliesByGoalKind
from eai.world.fault import FaultKind
from record_files import write_records


def record(response: str = '{"WALK": ["sofa"]}', model: str = "m") -> Record:
    verdict = PlanVerdict(executable=True, success=False)
    return Record(
        Protocol.STRICT, "lamps", Ability.ACTION_SEQUENCING, model, "27_2", response, "0" * 64, verdict
    )


def test_a_file_reads_as_it_was_written(tmp_path: Path) -> None:
    first, second = tmp_path / "first.jsonl", tmp_path / "second.jsonl"
    write_records(first, [record(), record(model="n")])
    read = list(read_records(first))
    assert read == [record(), record(model="n")]
    write_records(second, read)
    assert second.read_bytes() == first.read_bytes()


@given(st.text(st.characters(), max_size=20))
def test_any_response_is_read_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, response: str
) -> None:
    file = tmp_path_factory.mktemp("records") / "records.jsonl"
    write_records(file, [record(response)])
    assert [r.response for r in read_records(file)] == [response]
    assert file.read_bytes().count(b"\n") == 1


@pytest.mark.parametrize("response", ["", "\0", "\ud800", "\u2028\n\r", "é😀"])
def test_responses_with_odd_characters_are_read_unchanged(response: str, tmp_path: Path) -> None:
    write_records(tmp_path / "r.jsonl", [record(response)])
    assert [r.response for r in read_records(tmp_path / "r.jsonl")] == [response]


def test_empty_lines_are_skipped(tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record()])
    file.write_text(f"\n{file.read_text()}\n \n")
    assert list(read_records(file)) == [record()]


def changed(**fields: object) -> str:
    """Return a valid line with other fields; a field is left out if its value is `...`."""
    line: dict[str, Any] = {**record_to_json(record()), **fields}
    return json.dumps({key: value for key, value in line.items() if value is not ...})


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("{", "expected a JSON object"),
        ("[1]", "expected a record of a scored answer; eai score makes records of answers"),
        ('{"identifier": "1"}', "expected a record of a scored answer; eai score makes records of answers"),
        ("\0", "expected a JSON object"),
        ("[" * 100_000, "expected a JSON object"),
        ('{"schema": ' + "1" * 10_000 + "}", "expected a JSON object"),
        ("{}", "expected a record of a scored answer"),
        (changed(schema=None), "schema None cannot be read; expected 2"),
        (changed(schema=5), "schema 5 cannot be read; expected 2 or 3 or 4"),
        (changed(schema=[2]), "schema [2] cannot be read; expected 2"),
        (changed(task_id=...), "field task_id: is missing"),
        (changed(schema=1), "schema 1 cannot be read; expected 2"),
        (changed(response="another"), "expected the response that was scored"),
    ],
    ids=lambda text: text[:30],
)
def test_a_damaged_line_is_named(line: str, complaint: str, tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record()])
    file.write_text(file.read_text() + line + "\n")
    with pytest.raises(InputError) as caught:
        list(read_records(file))
    assert str(caught.value).startswith(f"{file}, line 2: {complaint}")
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.jsonl"):
        list(read_records(tmp_path / "none.jsonl"))
    (tmp_path / "binary.jsonl").write_bytes(b"\xff\xfe\0")
    with pytest.raises(InputError, match=r"binary\.jsonl"):
        list(read_records(tmp_path / "binary.jsonl"))


UNMET = TalliesByGoalKind(Share(1, 2), Share(0, 0), Share(0, 0))
MET = TalliesByGoalKind(Share(2, 2), Share(0, 0), Share(0, 0))
RIGHT = PlanVerdict(executable=True, success=True, goals=MET, goals_satisfied=(True, True))
WRONG = PlanVerdict(executable=True, success=False, goals=UNMET, goals_satisfied=(True, False))
FAILED = replace(WRONG, executable=False, error=ErrorReport(FaultKind.MISSING_STEP, 0, "why"))


@pytest.mark.parametrize(
    ("verdict", "fields", "complaint"),
    [
        (WRONG, {"success": True}, "success is true, although goals_satisfied has a goal that is missed"),
        (FAILED, {"success": True}, "success is true, although the error missing_step ended the answer"),
        (WRONG, {"success": True, "goals_satisfied": [True, True]}, "goals has a goal that is missed"),
        (RIGHT, {"success": False}, "success is false, although all goals hold and no error ended"),
        (FAILED, {"error": None, "executable": True, "success": True}, "success is true, although goals_"),
    ],
)
@pytest.mark.parametrize("ability", ["action_sequencing", "subgoal_decomposition"])
def test_a_verdict_that_contradicts_its_fields_is_refused(
    ability: str, verdict: PlanVerdict, fields: dict[str, object], complaint: str, tmp_path: Path
) -> None:
    file = tmp_path / "records.jsonl"
    line = record_to_json(replace(record(), verdict=verdict)) | {"ability": ability}
    file.write_text(json.dumps(line))
    assert len(list(read_records(file))) == 1
    file.write_text(json.dumps(line | fields))
    with pytest.raises(InputError, match=rf"^{file}, line 1: the verdict was changed: {complaint}"):
        list(read_records(file))
    file.write_text(json.dumps(line | fields | {"protocol": "eai-1.0.5"}))
    assert len(list(read_records(file))) == 1


def test_a_success_that_does_not_follow_from_the_counts_is_refused(tmp_path: Path) -> None:
    file, counts = tmp_path / "records.jsonl", {"all": ConfusionCounts(1, 0, 1)}
    line = record_to_json(
        replace(record(), ability=Ability.GOAL_INTERPRETATION, verdict=GoalVerdict(counts=counts))
    )
    assert line["success"] is False
    file.write_text(json.dumps(line | {"success": True}))
    with pytest.raises(InputError, match="the verdict was changed: success is true, but not by the other"):
        list(read_records(file))


def test_an_episode_is_lost_although_all_goals_hold_if_the_agent_did_not_say_so(tmp_path: Path) -> None:
    lost = EpisodeVerdict(executable=True, success=False, goals=MET, goals_satisfied=(True, True))
    file = tmp_path / "records.jsonl"
    write_records(file, [replace(record(), ability=Ability("acting"), verdict=lost)])
    assert len(list(read_records(file))) == 1
