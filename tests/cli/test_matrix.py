"""Every command works for every domain that opens, or says in one line why it does not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import eai as library
from by_path import ROOT, TESTS
from command_line import Command
from explorer_pages import read_explorer
from processes import eai as in_own_process
from sweeps import swept

WORLDS = TESTS / "worlds"
LAMPS = ROOT / "examples" / "lamps"


def pddl(name: str) -> str:
    return f"pddl:{WORLDS / name}.pddl,{WORLDS / name}-1.pddl"


DOMAINS = ["warehouse:warehouse", pddl("gate")]
MORE = ["lamps:lamps", *map(pddl, ("blocks", "briefcase", "circuit", "ferry")), "virtualhome", "behavior"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Works in an empty folder in which the modules of the worlds are found."""
    monkeypatch.chdir(tmp_path)
    for folder in (WORLDS, LAMPS):
        monkeypatch.syspath_prepend(folder)
        for file in folder.glob("*.py"):
            (tmp_path / file.name).write_text(file.read_text())


def rates(ability: str, model: str) -> dict[str, Any]:
    (file,) = Path("runs").glob(f"*/{ability}/{model}/summary.json")
    found: dict[str, Any] = json.loads(file.read_text())
    return found


@pytest.mark.parametrize("domain", [*DOMAINS, *swept(*MORE)])
def test_every_command_works(eai: Command, domain: str) -> None:
    is_own = ":" in domain
    asked = ("--domain", domain, "--limit", "1", "--planner", "built_in")
    for more in (("--model", "eai/oracle"), ("--model", "eai/explorer", "--ability", "acting")):
        outcome = in_own_process("run", *more, *asked)
        assert outcome.status == 0, outcome.err
    assert rates("action_sequencing", "eai_oracle")["task_success"]["numerator"] == 1

    def succeeds(*words: object) -> str:
        outcome = eai(*words)
        assert outcome.status == 0, outcome.err
        return outcome.out

    suite = library.open(domain, "action_sequencing")
    task_id, task = suite.task_ids[0], suite.tasks[suite.task_ids[0]]
    instruction = " ".join(task.instruction.split())
    told = succeeds("explain", "runs", task_id, "--model", "eai_oracle", "--json")
    by_default = {"action_sequencing", *(() if domain.startswith("pddl:") else ("goal_interpretation",))}
    assert {record["ability"] for record in json.loads(told)} >= by_default
    (folder,) = Path("runs").glob("*/action_sequencing/eai_oracle")
    assert instruction in " ".join(succeeds("explain", folder, task_id).split())
    succeeds("score", "runs", "--planner", "built_in", "--allow-missing", "--out", "scores")
    assert len([*Path("scores").rglob("records.jsonl")]) == len([*Path("runs").rglob("records.jsonl")])
    succeeds("report", "runs", "--no-plots", "--out", "report")
    explorer = read_explorer(Path("report/explorer.html").read_text(encoding="utf-8"))
    assert json.dumps(instruction)[1:-1] in json.dumps(explorer)
    succeeds(
        "export", "prompts", "--domain", domain, "--ability", "action_sequencing", "--out", "prompts.json"
    )
    assert json.loads(Path("prompts.json").read_text())[0]["identifier"].endswith(task_id)
    succeeds("generate", "--like", domain, "--n", 1, "--tier", "S", "--out", "new")
    assert "as they say" in succeeds("check", "new/")
    if is_own:
        outcome = eai(
            "generate", "--like", domain, "--n", 3, "--forms", "all", "--kind", "order", "--out", "timed"
        )
        assert outcome.status == 0 or "seeds gave no task: " in outcome.err
    succeeds("export", "tasks", "--domain", domain, "--out", "tasks.jsonl")
    if is_own:
        assert "nothing is wrong" in succeeds("check", domain)
        assert "as they say" in succeeds("check", "tasks.jsonl")


def test_where_goals_would_be_copied_they_are_asked_for_by_name_alone(eai: Command) -> None:
    asked = (
        "run",
        "--model",
        "eai/oracle",
        "--domain",
        pddl("gate"),
        "--limit",
        "1",
        "--planner",
        "built_in",
    )
    outcome = in_own_process(*asked)
    assert outcome.status == 0, outcome.err
    reason = "no goal_interpretation, as its instructions are the goals in PDDL, which need only be copied"
    assert outcome.err.count(reason) == 1
    assert {file.parts[2] for file in Path("runs").rglob("summary.json")} == {
        "action_sequencing",
        "subgoal_decomposition",
        "transition_modeling",
    }
    told = eai("export", "prompts", "--domain", pddl("gate"), "--out", "prompts.jsonl")
    assert told.status == 0
    assert reason in told.err
    assert "goal_interpretation" not in Path("prompts.jsonl").read_text()
    named = in_own_process(*asked, "--ability", "goal_interpretation", "--out", "named")
    assert named.status == 0
    assert reason not in named.err
    assert [*Path("named").rglob("goal_interpretation/eai_oracle/summary.json")]
