from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.record import SCHEMA, Record, read_records, sha256_of, write_records
from eai.abilities.verdict import (
    Confusion,
    ErrorReport,
    GoalTallies,
    PlannerOutcome,
    SubgoalCategory,
    Tally,
    Verdict,
)
from eai.errors import InputError
from eai.world.fault import FaultKind

VERDICTS = [
    Verdict(),
    Verdict(excluded="the task has no goals"),
    Verdict(
        executable=False,
        success=False,
        error=ErrorReport(FaultKind.WRONG_ORDER, 3, "the character is not next to soap.1002"),
        additional_steps=2,
        goals=GoalTallies(Tally(1, 2), Tally(0.5, 1), Tally(0, 0)),
        repairs=("code_fence", "single_quotes"),
        details={"data_set_order": {"success": True, "action": [2, 2]}},
    ),
    Verdict(executable=False, success=False, error=ErrorReport(FaultKind.PARSING, None, "no step was found")),
    Verdict(category=SubgoalCategory.GOAL_UNREACHABLE, success=False, error=None),
    Verdict(counts={"state": Confusion(1, 2, 3), "action": Confusion(0, 0, 0)}),
    Verdict(
        counts={"precondition": {"object_states": Confusion(1, 0, 2)}, "effect": {}},
        planner=PlannerOutcome.UNSOLVABLE,
    ),
]


def record(verdict: Verdict, response: str = '{"WALK": ["sofa"]}', model: str = "m") -> Record:
    return Record(
        Protocol.STRICT,
        "virtualhome",
        Ability.ACTION_SEQUENCING,
        model,
        "27_2",
        response,
        "0" * 64,
        verdict,
    )


@pytest.mark.parametrize("verdict", VERDICTS)
def test_a_record_reads_as_it_was_written(verdict: Verdict, tmp_path: Path) -> None:
    first, second = tmp_path / "first.jsonl", tmp_path / "second.jsonl"
    write_records(first, [record(verdict), record(verdict, model="n")])
    read = list(read_records(first))
    assert read == [record(verdict), record(verdict, model="n")]
    write_records(second, read)
    assert second.read_bytes() == first.read_bytes()


@given(st.text(st.characters(), max_size=20))
def test_any_response_survives(tmp_path_factory: pytest.TempPathFactory, response: str) -> None:
    file = tmp_path_factory.mktemp("records") / "records.jsonl"
    write_records(file, [record(Verdict(), response)])
    assert [r.response for r in read_records(file)] == [response]
    assert file.read_bytes().count(b"\n") == 1


@pytest.mark.parametrize("response", ["", "\0", "\ud800", "\u2028\n\r", "é😀"])
def test_odd_responses_survive(response: str, tmp_path: Path) -> None:
    write_records(tmp_path / "r.jsonl", [record(Verdict(), response)])
    assert [r.response for r in read_records(tmp_path / "r.jsonl")] == [response]


def test_the_digest_tells_texts_apart() -> None:
    texts = ["", "a", "\ud800", "\udc00", "\ufffd", "?"]
    assert len({sha256_of(text) for text in texts}) == len(texts)


def test_a_line_has_the_fields_of_the_contract() -> None:
    line = record(VERDICTS[2]).to_json()
    assert line["schema"] == SCHEMA
    assert line["status"] == "scored"
    assert line["error"] == {
        "kind": "wrong_order",
        "step": 3,
        "detail": "the character is not next to soap.1002",
    }
    assert line["goals"] == {"state": [1, 2], "relation": [0.5, 1], "action": [0, 0]}
    assert line["repairs"] == ["code_fence", "single_quotes"]
    assert line["data_set_order"] == {"success": True, "action": [2, 2]}
    assert list(line) == [
        "schema",
        "protocol",
        "domain",
        "ability",
        "model",
        "task_id",
        "response_sha256",
        "data_sha256",
        "status",
        "excluded_reason",
        "executable",
        "success",
        "error",
        "additional_steps",
        "category",
        "goals",
        "counts",
        "planner",
        "repairs",
        "data_set_order",
        "response",
    ]


def test_empty_lines_are_skipped(tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record(Verdict())])
    file.write_text(f"\n{file.read_text()}\n \n")
    assert list(read_records(file)) == [record(Verdict())]


def changed(**fields: object) -> str:
    """A good line with other fields; a field is left out if it is `...`."""
    line = {**record(VERDICTS[2]).to_json(), **fields}
    return json.dumps({key: value for key, value in line.items() if value is not ...})


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("{", "expected a JSON object"),
        ("[1]", "expected a JSON object"),
        ("\0", "expected a JSON object"),
        ("[" * 100_000, "expected a JSON object"),
        ('{"schema": ' + "1" * 10_000 + "}", "expected a JSON object"),
        ("{}", "schema None, expected 1"),
        (changed(schema=2), "schema 2, expected 1"),
        (changed(task_id=...), "field task_id: Field required"),
        (changed(task_id=3), "field task_id"),
        (changed(protocol="lenient"), "field protocol"),
        (changed(ability="cooking"), "field ability"),
        (changed(status="lost"), "field status"),
        (changed(error={"kind": "unlucky", "step": None, "detail": ""}), "field error.kind"),
        (changed(goals={"state": [1, 2]}), "field goals.relation: Field required"),
        (changed(goals={"state": [1], "relation": [0, 0], "action": [0, 0]}), "field goals.state.1"),
        (
            changed(goals={"state": [1, 2], "relation": [0, 0], "action": [0, 0], "x": [0, 0]}),
            "field goals.x",
        ),
        (changed(counts={"state": [1, 2]}), "field counts.state"),
        (changed(additional_steps="many"), "field additional_steps"),
        (changed(response="another"), "expected the response that was scored"),
        (changed(response_sha256="0" * 64), "expected the response that was scored"),
        (changed(response=""), "expected the response that was scored"),
    ],
    ids=lambda text: text[:30],
)
def test_a_damaged_line_is_named(line: str, complaint: str, tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    write_records(file, [record(Verdict())])
    file.write_text(file.read_text() + line + "\n")
    with pytest.raises(InputError) as caught:
        list(read_records(file))
    assert str(caught.value).startswith(f"{file}, line 2: {complaint}")
    assert "\n" not in str(caught.value)


def test_a_record_may_lack_its_response(tmp_path: Path) -> None:
    file = tmp_path / "records.jsonl"
    file.write_text(changed(response=...) + "\n")
    assert [each.response for each in read_records(file)] == [""]


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.jsonl"):
        list(read_records(tmp_path / "none.jsonl"))
    (tmp_path / "binary.jsonl").write_bytes(b"\xff\xfe\0")
    with pytest.raises(InputError, match=r"binary\.jsonl"):
        list(read_records(tmp_path / "binary.jsonl"))
