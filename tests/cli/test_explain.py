from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from by_path import ROOT
from command_line import Command
from eai.base.store import DataPackStore
from processes import eai as run_eai

HERE = ("--domain", "virtualhome", "--ability", "action_sequencing")
ANSWERS = {
    "27_2": '{"WALK": ["soap"], "WALK": ["washing_machine"], "PUTIN": ["soap", "washing_machine"]}',
    "11_1": '```{"STANDUP": [], "WALK": ["floor_lamp"], "SWITCHON": ["floor_lamp"]}```',
    "12_2": "I cannot.",
}


@pytest.fixture(autouse=True)
def scored(eai: Command, data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
        "virtualhome action_sequencing 11_1  Turn on light",
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


def test_lines_go_on_below_their_beginning_where_the_screen_is_narrow(
    eai: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    _, *lines = eai("explain", "out", "27_2").out.splitlines()
    assert max(map(len, lines)) <= 40
    assert [line for line in lines if not line.startswith(" ")] == [
        "model m, protocol strict",
        "goals, 2 of 5 conditions met",
        "failure, not executable",
    ]


def test_an_unreadable_answer_is_explained(eai: Command) -> None:
    out = eai("explain", "out", "12_2").out
    assert "parsing: there is no object or list of actions with their objects" in " ".join(out.split())
    assert "goals, 0 of 2 conditions met: none counts, as nothing was carried out\n" in out


def test_a_record_without_an_explanation_says_how_to_get_one(eai: Command) -> None:
    outcome = eai("explain", damaged(explanation=None), "27_2")
    assert (outcome.status, outcome.err) == (0, "")
    lines = outcome.out.splitlines()
    assert lines[2] == "the record has no explanation; score the answer with --explanations to get one"
    assert lines[3] == "missing_step: the character does not hold soap.1002"
    assert lines[-1] == "failure, not executable"


def test_a_record_of_another_domain_is_shown_all_the_same(eai: Command) -> None:
    assert eai("explain", damaged(domain="mars"), "27_2").out.startswith(
        "mars action_sequencing 27_2  Wash clothes\n"
    )


def test_goals_are_judged_by_what_they_came_to(eai: Command) -> None:
    goals: dict[str, object] = {"ability": "goal_interpretation", "explanation": None, "error": None}
    found = damaged(**goals, counts={"state": [1, 1, 0]})
    assert eai("explain", found, "27_2").out.endswith("partly right\n")


def test_parts_of_a_temporal_goal_are_shown_in_order(eai: Command) -> None:
    parts = [
        {"part": "ON(lamp.1)", "met_after": 2, "missing": []},
        {"part": "TOUCH(lamp.1)", "met_after": 2, "missing": [], "met_at": 4},
        {"part": "OPEN(box.2)", "met_after": None, "missing": ["OPEN(box.2)"]},
    ]
    told = {"notes": [], "steps": [], "goals": [], "parts": parts}
    lines = [line.rstrip() for line in eai("explain", damaged(explanation=told), "27_2").out.splitlines()]
    assert lines[2:6] == [
        "temporal goal",
        "  ✓ ON(lamp.1)  after step 2",
        "  ✓ TOUCH(lamp.1)  at step 4",
        "  ✗ OPEN(box.2)  never after that: OPEN(box.2)",
    ]
    told = {**told, "parts": parts[2:]}
    assert "✗ OPEN(box.2)  never: OPEN(box.2)" in eai("explain", damaged(explanation=told), "27_2").out


def test_one_more_change_is_told_in_the_singular(eai: Command) -> None:
    step = {"action": "SIT(couch.1)", "outcome": "executed", "call": ["SIT", ["couch.1"], True]}
    for number, told in ((1, "1 more change, not shown"), (2, "2 more changes, not shown")):
        explanation = {"notes": [], "steps": [{**step, "hidden_changes": number}], "goals": [], "parts": []}
        assert told in eai("explain", damaged(explanation=explanation), "27_2").out


def test_what_is_wrong_with_the_records_is_told_in_one_line(eai: Command) -> None:
    assert eai("explain", "out", "0_0") == (2, "", "eai: out: no record of task 0_0\n")
    assert eai("explain", "none", "0_0").err == "eai: none: no such file or folder\n"
    run = Path("interrupted")
    (run / "logs").mkdir(parents=True)
    (run / "run.toml").write_text("")
    (run / "logs" / "a.eval").write_bytes(b"PK\x03\x04 _journal/")
    assert eai("explain", run).err == (
        "eai: interrupted: expected a folder with records.jsonl somewhere below, found none; eai score "
        "writes this file, and eai run at its end\n"
    )
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


def test_answers_are_found_by_how_an_id_begins_and_by_words_of_a_title(eai: Command) -> None:
    assert eai("explain", "out", "27_").out.startswith("virtualhome action_sequencing 27_2 ")
    assert re.search(r"27_2 +missing_step", eai("explain", "out", "wash CLOTHES", "--limit", "0").out)
    listed = eai("explain", "out", "1", "--limit", "0").out
    assert re.search(r"11_1 +success", listed)
    assert re.search(r"12_2 +parsing", listed)
    assert "refusal: there is no object or list of actions" in " ".join(listed.split())


def test_failures_are_listed_with_their_reasons(eai: Command) -> None:
    failed = eai("explain", "out", "--failed", "--limit", "0").out
    assert not re.search(r"^11_1 ", failed, re.MULTILINE)
    why = "step 3: the character does not hold soap.1002"
    assert re.search(rf"^27_2 +missing_step *\nWash clothes +{why}", failed, re.MULTILINE)
    kind = eai("explain", "out", "--kind", "missing_step").out
    assert kind.count("missing_step") == 1
    assert kind.endswith("\n1 answer\n")
    few = eai("explain", "out", "--kind", "not_answered", "--limit", "3").out
    assert few.endswith("334 answers, of which 3 are shown (--limit 0: all)\n")
    assert [
        line["task_id"] for line in json.loads(eai("explain", "out", "--kind", "parsing", "--json").out)
    ] == ["12_2"]


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (("27_3",), "no record of task 27_3; did you mean 27_2?"),
        (("--kind", "missing_stp"), "; did you mean missing_step?"),
        (("--model", "mm"), "--model mm: expected one of m; did you mean m?"),
    ],
)
def test_what_is_not_there_comes_with_what_is_near(
    eai: Command, arguments: tuple[str, ...], hint: str
) -> None:
    outcome = eai("explain", "out", *arguments)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.endswith(f"{hint}\n")


def test_one_household_is_at_hand_without_the_other(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    """The first command fetches VirtualHome alone, and its answers are explained in full."""
    kept = [file for file in data_store.folder.glob("*.zip") if not file.name.startswith("behavior.")]
    (tmp_path / "store").mkdir()
    for file in kept:
        (tmp_path / "store" / file.name).symlink_to(file)
    done = eai("explain", "out", "27_2", "--data", tmp_path / "store")
    assert "the data set's plan (14 steps)" in done.out


def test_the_data_set_says_what_it_knows_where_it_is_at_hand(eai: Command, data_store: DataPackStore) -> None:
    lines = eai("explain", "out", "27_2", "--data", data_store.folder).out.splitlines()
    assert lines[1].startswith("  Walk to the kitchen and find the basket of clothes.")
    assert "the data set's plan (14 steps)" in lines
    assert "  1 WALK(dining_room.201)" in [line.rstrip() for line in lines]


def test_steps_that_were_not_tried_any_more_are_told(eai: Command, data_store: DataPackStore) -> None:
    answer = '{"WALK": ["soap"], "PUTIN": ["soap", "washing_machine"], "OPEN": ["washing_machine"]}'
    Path("n_outputs.json").write_text(json.dumps([{"identifier": "27_2", "llm_output": answer}]))
    here = ("--data", data_store.folder)
    assert eai("score", "n_outputs.json", *HERE, *here, "--out", "rest").status == 0
    shown = eai("explain", "rest", "27_2", *here).out
    assert re.search(r"  2 PUTIN.* missing_step: .*\n  3 OPEN\(washing_machine.1001\) +not tried", shown)


def test_no_step_of_an_unreadable_answer_is_called_not_tried(eai: Command, data_store: DataPackStore) -> None:
    answer = '{"WALK": ["soap"]}\nOPEN washing_machine'
    Path("n_outputs.json").write_text(json.dumps([{"identifier": "27_2", "llm_output": answer}]))
    here = ("--data", data_store.folder)
    assert eai("score", "n_outputs.json", *HERE, *here, "--out", "rest").status == 0
    shown = eai("explain", "rest", "27_2", *here).out
    assert "parsing: " in shown
    assert "not tried" not in shown


def test_what_holds_both_ways_is_told_once(eai: Command) -> None:
    shown = eai("explain", "out", "27_2").out
    assert "+ NEXT_TO(character.65, soap.1002), and back" in shown
    assert "NEXT_TO(soap.1002, character.65)" not in shown


def test_the_readme_shows_what_the_command_prints(
    eai: Command, data_store: DataPackStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    answers, shown = (
        re.findall(rf"^```{kind}\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[0] for kind in ("json", "text")
    )
    Path("mine_outputs.json").write_text(answers)
    here = ("--data", data_store.folder)
    assert eai("score", "mine_outputs.json", *HERE, *here, "--out", "mine").status == 0
    monkeypatch.setenv("COLUMNS", "80")
    lines = [line.rstrip() for line in eai("explain", "mine", "27_2", *here).out.splitlines()]
    assert shown in "\n".join(lines) + "\n"


def test_the_readme_shows_what_a_run_prints(data_store: DataPackStore, tmp_path: Path) -> None:
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    pattern = r"^\$ eai (run [^\n]*)\n```\n\n```text\n(.*?)^```$"
    command, shown = re.findall(pattern, page, re.MULTILINE | re.DOTALL)[0]
    assert shown in run_eai(*command.split(), "--data", data_store.folder).out
    assert not (tmp_path / "nothing").exists()  # neither the model nor Inspect fetched the data set there


def test_an_answer_and_a_model_with_odd_characters_are_shown_as_their_escapes(
    eai: Command, data_store: DataPackStore
) -> None:
    here = ("--data", data_store.folder)
    name = "=m\x1b[2J[red]_outputs.json"
    odd = '{"WALK": ["so\ud800ap\\u001b[31m"]}'
    Path(name).write_text(json.dumps([{"identifier": "27_2", "llm_output": odd}]))
    scored = eai("score", name, *HERE, *here, "--out", "odd")
    shown = eai("explain", "odd", "27_2")
    assert (scored.status, shown.status, shown.err) == (0, 0, "")
    assert r"=m\x1b[2J[red]" in scored.out
    assert r"model =m\x1b[2J[red], protocol strict" in shown.out
    assert r"so\ud800ap\x1b[31m" in shown.out
    assert eai("report", "odd", "--out", "made", "--no-plots", "--no-prompts").status == 0
    page, tables = (Path("made", file).read_bytes().decode() for file in ("report.md", "tables.csv"))
    assert "\x1b" not in page + tables + scored.out + scored.err + shown.out
    assert ",'=m\\x1b[2J[red]," in tables
