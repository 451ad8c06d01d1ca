"""Tests that the example world works with all commands from its declaration alone."""

from __future__ import annotations

import json
import random
import shutil
from pathlib import Path
from typing import Any

import pytest

import eai as library
from by_path import ROOT
from command_line import Command
from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.results.paper_tables import NULL_MODELS
from eai.world import Action, Episode, check_domain, execute_plan
from explorer_pages import read_explorer
from processes import eai as in_own_process
from sweeps import first_of

FOLDER = ROOT / "examples" / "lamps"
LAMPS = "lamps:lamps"
PRESS = [
    {"action": "GO", "object": "lamp_1"},
    {"action": "PRESS", "object": "lamp_1"},
    {"action": "GO", "object": "lamp_2"},
    {"action": "PRESS", "object": "lamp_2"},
]
RIGHT = {
    "action_sequencing": PRESS,
    "goal_interpretation": {"node goals": [["lit", "lamp_1"], ["lit", "lamp_2"]]},
    "subgoal_decomposition": {"output": ["lit(lamp_1)", "lit(lamp_2)"]},
}
"""A right answer to the task "light", by ability."""

WRONG = {
    "action_sequencing": PRESS[:1] + PRESS[3:],
    "goal_interpretation": {"node goals": [["lit", "lamp_1"], ["is_open", "box"]]},
    "subgoal_decomposition": {"output": ["lit(lamp_1)"]},
}


PLANNED = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
"""Abilities whose right answer is a plan."""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder with the example's file, as its author would."""
    shutil.copy(FOLDER / "lamps.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


def score(eai: Command, ability: str, answers: dict[str, object]) -> dict[str, dict[str, Any]]:
    """Score answers and return their records by task."""
    rows = [{"identifier": task, "llm_output": json.dumps(answer)} for task, answer in answers.items()]
    Path("m_outputs.json").write_text(json.dumps(rows))
    outcome = eai("score", "m_outputs.json", "--domain", LAMPS, "--ability", ability, "--out", "out")
    assert outcome.status == 0, outcome.err
    records = map(json.loads, Path("out/records.jsonl").read_text().splitlines())
    return {record["task_id"]: record for record in records}


def test_the_example_is_as_short_as_the_page_says() -> None:
    files = [path for path in FOLDER.iterdir() if path.is_file()]
    assert sum(len(path.read_text().splitlines()) for path in files) <= 60


def test_the_example_passes_the_conformance_checks() -> None:
    benchmark = library.find_benchmark(LAMPS)
    tasks = benchmark.tasks(library.Source())
    assert check_domain(benchmark.domain, [task.initial for task in tasks.values()]) == ()


def test_random_plans_run_in_an_episode_as_they_are_executed() -> None:
    benchmark = library.find_benchmark(LAMPS)
    initial = benchmark.tasks(library.Source())["pack"].initial
    objects = range(len(initial.scene.objects))
    rng = random.Random(0)
    for _ in range(200):
        chosen = rng.choices(benchmark.domain.operators, k=12)
        plan = [Action(each.name, tuple(rng.choices(objects, k=each.arity))) for each in chosen]
        episode = Episode(benchmark.domain, initial)
        episode.run(plan)
        assert episode.trajectory == execute_plan(benchmark.domain, initial, plan)


@pytest.mark.parametrize("ability", ["action_sequencing", "subgoal_decomposition"])
def test_plans_and_subgoals_are_scored(eai: Command, ability: str) -> None:
    assert score(eai, ability, {"light": RIGHT[ability]})["light"]["success"]
    wrong = score(eai, ability, {"light": WRONG[ability]})["light"]
    assert not wrong["success"]
    assert wrong["goals"]["state"] == [0, 1]


def test_a_failing_step_is_diagnosed_and_explained(eai: Command) -> None:
    error = score(eai, "action_sequencing", {"light": WRONG["action_sequencing"]})["light"]["error"]
    assert (error["kind"], error["step"]) == ("missing_step", 1)
    assert error["detail"] == "the robot is not at lamp_2"
    assert (error["check"], error["objects"]) == ("the_robot_is_not_at", ["lamp_2"])
    out = eai("explain", "out", "light").out
    assert "missing_step: the robot is not at lamp_2" in out
    assert "+ at(robot, lamp_1)" in out


def test_goals_are_counted(eai: Command) -> None:
    ability = "goal_interpretation"
    assert score(eai, ability, {"light": RIGHT[ability]})["light"]["counts"]["state"] == [2, 0, 0]
    assert score(eai, ability, {"light": WRONG[ability]})["light"]["counts"]["state"] == [1, 1, 1]


@pytest.mark.parametrize("model", ["eai/oracle", "eai/noisy", "eai/planner", *first_of(NULL_MODELS)])
def test_built_in_models_run(model: str) -> None:
    pytest.importorskip("inspect_ai")
    abilities = PLANNED if model == "eai/planner" else PAPER_ABILITIES
    asked = [word for ability in abilities for word in ("--ability", ability.value)]
    options = ("--planner", "built_in", "--out", "runs")
    outcome = in_own_process("run", "--model", model, "--domain", LAMPS, *asked, *options)
    assert outcome.status == 0, outcome.err
    for ability in abilities:
        folder = Path("runs/lamps", ability.value, model.replace("/", "_"))
        summary = json.loads((folder / "summary.json").read_text())
        assert summary[next(iter(get_declaration(ability).overview_headings))][
            "value"
        ] == 100.0 or model not in (
            "eai/oracle",
            "eai/planner",
        ), ability


def test_tasks_are_generated_run_and_reported(eai: Command) -> None:
    """The example has no code for generation."""
    pytest.importorskip("inspect_ai")
    assert eai("generate", "--like", LAMPS, "--n", 5, "--out", "fresh").status == 0
    assert eai("check", "fresh").status == 0
    options = ("--ability", "action_sequencing", "--ability", "goal_interpretation", "--out", "runs")
    for model in ("eai/oracle", "eai/random"):
        abilities = ("--domain", "fresh/", *options)
        outcome = in_own_process("run", "--model", model, *abilities)
        assert outcome.status == 0, outcome.err
    folder = Path("runs/lamps-fresh/action_sequencing")
    solved = json.loads((folder / "eai_oracle" / "summary.json").read_text())["task_success"]
    assert (solved["numerator"], solved["denominator"]) == (5, 5)
    assert eai("report", "runs", "--out", "report").status == 0
    assert any("lamps-fresh" in file.read_text() for file in Path("report").rglob("*.md"))


@pytest.mark.parametrize("ability", [each.value for each in PAPER_ABILITIES])
def test_prompts_are_written(eai: Command, ability: str) -> None:
    assert (
        eai("export", "prompts", "--domain", LAMPS, "--ability", ability, "--out", "prompts.json").status == 0
    )
    prompts = {row["identifier"]: row["llm_prompt"] for row in json.loads(Path("prompts.json").read_text())}
    assert prompts.keys() == {"light", "pack"}
    assert "lamp_1" in prompts["light"]


def test_a_report_is_made(eai: Command) -> None:
    score(eai, "action_sequencing", {"light": RIGHT["action_sequencing"], "pack": []})
    outcome = eai("report", "out", "--out", "report", "--no-plots")
    assert (outcome.status, outcome.err) == (0, "")
    explorer = read_explorer(Path("report/explorer.html").read_text(encoding="utf-8"))
    assert "lamps" in explorer["runs"][0]["domain"]


def test_worker_processes_find_the_example(eai: Command) -> None:
    rows = [{"identifier": task, "llm_output": json.dumps(PRESS)} for task in ("light", "pack")]
    Path("m_outputs.json").write_text(json.dumps(rows))
    arguments = ("m_outputs.json", "--domain", LAMPS, "--ability", "action_sequencing")
    for workers in (1, 2):
        assert eai("score", *arguments, "--workers", workers, "--out", f"out_{workers}").status == 0
    assert Path("out_1/records.jsonl").read_bytes() == Path("out_2/records.jsonl").read_bytes()
