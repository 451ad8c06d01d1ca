from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from cli.conftest import Command
from eai.data.store import Store

HERE = ("--domain", "virtualhome", "--ability", "action_sequencing")
ANSWERS = {
    "27_2": '{"WALK": ["soap"], "WALK": ["washing_machine"], "PUTIN": ["soap", "washing_machine"]}',
    "11_1": '```{"STANDUP": [], "WALK": ["floor_lamp"], "SWITCHON": ["floor_lamp"]}```',
    "12_2": "I cannot.",
}


@pytest.fixture(autouse=True)
def scored(eai: Command, data_store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The answers, scored into the folder `out` of an empty folder to work in."""
    monkeypatch.setenv("EAI_DATA_DIR", str(data_store.folder))
    monkeypatch.chdir(tmp_path)
    rows = [{"identifier": task, "llm_output": text} for task, text in ANSWERS.items()]
    Path("m_outputs.json").write_text(json.dumps(rows))
    assert eai("score", "m_outputs.json", *HERE, "--out", "out").status == 0
    monkeypatch.setenv("EAI_DATA_DIR", str(tmp_path / "nothing"))


def damaged(**fields: object) -> Path:
    """The first record with other fields, in a file of its own."""
    line: dict[str, Any] = json.loads(Path("out/records.jsonl").read_text().splitlines()[0])
    Path("damaged.jsonl").write_text(json.dumps({**line, **fields}) + "\n")
    return Path("damaged.jsonl")


@pytest.mark.parametrize("where", ["out", "out/records.jsonl"])
def test_steps_goals_and_verdict_are_shown(eai: Command, where: str) -> None:
    outcome = eai("explain", where, "11_1")
    assert (outcome.status, outcome.err) == (0, "")
    lines = [line.rstrip() for line in outcome.out.splitlines()]
    assert lines[:3] == [
        "virtualhome action_sequencing 11_1",
        "model m, protocol strict",
        "read with repair: code_fence",
    ]
    assert "  1 STANDUP()                  additional_step: the character stands already" in lines
    assert "  2 WALK(floor_lamp.1000)      ok" in lines
    assert "      + ON(floor_lamp.1000)" in lines
    assert "      - OFF(floor_lamp.1000)" in lines
    assert "  ✓ state    ON(floor_lamp.1000)" in lines
    assert lines[-1] == "success"


def test_a_failing_step_is_shown_with_the_check_and_the_objects(eai: Command) -> None:
    out = eai("explain", "out", "27_2").out
    assert "missing_step: the character does not hold soap.1002" in out
    assert out.endswith("failure, not executable\n")


def test_an_unreadable_answer_is_explained(eai: Command) -> None:
    assert "parsing: no step was found" in eai("explain", "out", "12_2").out


def test_a_record_without_an_explanation_says_how_to_get_one(eai: Command) -> None:
    outcome = eai("explain", damaged(explanation=None), "27_2")
    assert (outcome.status, outcome.err) == (0, "")
    lines = outcome.out.splitlines()
    assert lines[2] == "the record has no explanation; score the answer with --explanations to get one"
    assert lines[3] == "missing_step: the character does not hold soap.1002"
    assert lines[-1] == "failure, not executable"


def test_a_record_of_another_domain_is_shown_all_the_same(eai: Command) -> None:
    assert eai("explain", damaged(domain="mars"), "27_2").out.startswith("mars action_sequencing 27_2\n")


def test_goals_are_judged_by_what_they_came_to(eai: Command) -> None:
    goals: dict[str, object] = {"ability": "goal_interpretation", "explanation": None, "error": None}
    found = damaged(**goals, counts={"state": [1, 1, 0]})
    assert eai("explain", found, "27_2").out.endswith("partly right\n")


def test_parts_of_a_temporal_goal_are_shown_in_order(eai: Command) -> None:
    parts = [
        {"part": "ON(lamp.1)", "met_after": 2, "missing": []},
        {"part": "OPEN(box.2)", "met_after": None, "missing": ["OPEN(box.2)"]},
    ]
    told = {"notes": [], "steps": [], "goals": [], "parts": parts}
    lines = [line.rstrip() for line in eai("explain", damaged(explanation=told), "27_2").out.splitlines()]
    assert lines[2:5] == [
        "temporal goal",
        "  ✓ ON(lamp.1)  after step 2",
        "  ✗ OPEN(box.2)  never: OPEN(box.2)",
    ]


def test_what_is_wrong_with_the_records_is_told_in_one_line(eai: Command) -> None:
    assert eai("explain", "out", "0_0") == (2, "", "eai: out/records.jsonl: no record of task 0_0\n")
    assert eai("explain", "none", "0_0").err.startswith("eai: none: expected a readable records.jsonl")
    Path("bad.jsonl").write_text("[" * 100_000)
    assert eai("explain", "bad.jsonl", "0_0").err.startswith("eai: bad.jsonl, line 1: expected a JSON object")


@pytest.mark.parametrize(
    ("fields", "task", "complaint"),
    [
        ({"explanation": {"steps": 3}}, "27_2", "damaged.jsonl, line 1: field explanation.steps: "),
        ({"response": "{}"}, "27_2", "damaged.jsonl, line 1: expected the response that was scored"),
        ({"protocol": "lenient"}, "27_2", "damaged.jsonl, line 1: field protocol: "),
    ],
)
def test_a_record_that_cannot_be_explained_is_told_in_one_line(
    eai: Command, fields: dict[str, object], task: str, complaint: str
) -> None:
    outcome = eai("explain", damaged(**fields), task)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"eai: {complaint}")
    assert outcome.err.count("\n") == 1
