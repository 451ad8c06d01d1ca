from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlsplit

import pytest

from command_line import Command
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.runs import read_runs
from eai.tasks.source import Source
from experiments import experiment
from results.verdicts import record
from studies.report.samples import action_run, goal_run, operator_run, write_runs
from studies.told import read_table, told_tables
from suites import answer_book

OF_ANSWERS = ("cofactors", "errors", "goals")
"""Analyses of any answers; extensions may have more."""


def test_tables_have_the_same_bytes_each_time(eai: Command, tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run("first"), goal_run()])
    for folder in ("one", "two"):
        outcome = eai("analyze", "table", runs, "--out", tmp_path / folder)
        assert outcome.status == 0
        assert outcome.out.startswith("16 answers, 44 steps, 22 goals, 0 atoms, 0 clauses; in ")
    for file in sorted((tmp_path / "one").iterdir()):
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()
    assert {file.name for file in (tmp_path / "one").iterdir()} == {
        f"{name}.csv" for name in ("answers", "steps", "goals", "atoms", "clauses")
    }


def must_have_the_same_bytes(eai: Command, folder: Path, name: str) -> None:
    """Fail unless an analysis writes the same files if it is made again."""
    records = [*(action_run(model) for model in ("first", "second", "third")), goal_run(), operator_run()]
    runs = write_runs(folder / "runs", records)
    for out in ("one", "two"):
        outcome = eai("analyze", name, runs, "--out", folder / out)
        assert (outcome.status, outcome.err) == (0, "")
    written = sorted((folder / "one").iterdir())
    assert [file.read_bytes() for file in written] == [
        (folder / "two" / file.name).read_bytes() for file in written
    ]
    assert {f"{name}.md", f"{name}.json"} < {file.name for file in written}


@pytest.mark.parametrize("name", OF_ANSWERS)
def test_analyses_have_the_same_bytes_each_time(eai: Command, tmp_path: Path, name: str) -> None:
    pytest.importorskip("scipy")
    must_have_the_same_bytes(eai, tmp_path, name)


def test_operators_are_tried_and_written_with_the_same_bytes(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    """The first model writes the gold operators. The second writes no operator, so all of its plans fail."""
    ability = Ability.TRANSITION_MODELING
    source = Source(data_store, planner=PlannerChoice.NONE)
    suite = open_suite("virtualhome", ability, source=source)
    book = answer_book("virtualhome", ability, data_store)
    task = suite.task_ids[0]
    runs = [
        [record(task, suite.scorer(task).score(text), ability=ability, model=model, response=text)]
        for model, text in (("gold", book[task].text), ("none", '{"output": ""}'))
    ]
    folder = write_runs(tmp_path / "runs", runs)
    for name in ("one", "two"):
        ways = ("--with", "replace=operator,effect", "--with", "planner=built_in")
        done = eai("analyze", "sensitivity", folder, *ways, "--json", "--out", tmp_path / name)
        assert done.status == 0, done.err
    told = told_tables(done.out)["sensitivity"]
    assert {(row["model"], float(row["solved"])) for row in told} == {
        ("all models", 50),
        ("gold", 100),
        ("none", 0),
    }
    written = sorted((tmp_path / "one").iterdir())
    assert [file.read_bytes() for file in written] == [
        (tmp_path / "two" / file.name).read_bytes() for file in written
    ]
    tables = json.loads((tmp_path / "one" / "sensitivity.json").read_text())["tables"]
    solved = {(row["model"], row["solved"]["value"]) for row in tables["sensitivity"]["rows"]}
    assert solved == {("all models", 50), ("gold", 100), ("none", 0)}


def test_sensitivity_needs_operators_and_a_planner(eai: Command, tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run("first")])
    assert (
        "the records have no answers to transition modeling"
        in eai("analyze", "sensitivity", runs, "--out", tmp_path / "a").err
    )
    none = eai("analyze", "sensitivity", runs, "--with", "planner=none", "--out", tmp_path / "a")
    assert (
        none.err == "eai: planner=none: this analysis tries operators with a planner; give another planner\n"
    )


def test_all_analyses_are_those_of_the_single_commands(eai: Command, tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    records = [*(action_run(model) for model in ("first", "second", "third")), goal_run(), operator_run()]
    runs = write_runs(tmp_path / "runs", records)
    assert eai("analyze", "all", runs, "--no-plots", "--out", tmp_path / "all").status == 0
    names = [folder.name for folder in (tmp_path / "all").iterdir()]
    assert {*OF_ANSWERS} <= {*names}
    for name in names:
        assert eai("analyze", name, runs, "--no-plots", "--out", tmp_path / name).status == 0
        together = {file.name: file.read_bytes() for file in (tmp_path / "all" / name).iterdir()}
        assert together == {file.name: file.read_bytes() for file in (tmp_path / name).iterdir()}


def test_figures_are_svg_unless_other_formats_are_named(eai: Command, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    runs, out = write_runs(tmp_path / "runs", [action_run("first"), action_run("second")]), tmp_path / "out"
    refused = eai("analyze", "errors", runs, "--out", out, "--formats", "svg,bmp")
    assert refused.err == "eai: --formats: expected some of svg, png, pdf, not 'svg,bmp'\n"
    assert not out.exists()
    for more, endings in (((), {".svg"}), (("--formats", "pdf,png"), {".svg", ".png", ".pdf"})):
        assert eai("analyze", "errors", runs, "--out", out, *more).status == 0
        assert {file.suffix for file in out.iterdir()} - {".csv", ".json", ".md"} == endings


def test_what_was_written_is_told_as_json(eai: Command, tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    records = [*(action_run(model) for model in ("first", "second", "third")), goal_run()]
    runs, out = write_runs(tmp_path / "runs", records), tmp_path / "all"
    told = json.loads(eai("analyze", "all", runs, "--no-plots", "--json", "--out", out).out)
    assert [each["folder"] for each in told] == [str(folder) for folder in sorted(out.iterdir())]
    assert {*OF_ANSWERS} <= {folder.name for folder in out.iterdir()}
    for each in told:
        assert each["plots"] == 0
        assert each["tables"]
        assert all((Path(each["folder"]) / f"{name}.csv").is_file() for name in each["tables"])
    arguments = (runs, "--no-plots", "--json", "--out", tmp_path / "one")
    (single,) = json.loads(eai("analyze", "errors", *arguments).out)
    assert single["tables"] == told[1]["tables"]
    table = json.loads(eai("analyze", "table", runs, "--json", "--out", tmp_path / "table").out)
    assert table["lines"]["answers"] == sum(map(len, records))


@pytest.mark.parametrize("made_with", [None, Experiment(effort="low"), experiment(replans=2, scene="image")])
def test_examples_lead_into_the_explorer(eai: Command, tmp_path: Path, made_with: Experiment | None) -> None:
    """The link is relative, and its run and task are those that the page knows."""
    records = [replace(record, experiment=made_with) for record in action_run("first")]
    runs, out = write_runs(tmp_path / "runs", [records]), tmp_path / "analyses" / "errors"
    (name,) = [run.key.name for run in read_runs([runs])]
    assert eai("report", runs, "--no-plots", "--no-prompts", "--out", tmp_path / "my report").status == 0
    page = tmp_path / "my report" / "explorer.html"
    done = eai("analyze", "errors", runs, "--no-plots", "--with", f"explorer={page}", "--out", out)
    assert done.status == 0, done.err
    (rows, told) = read_table(out / "examples.csv"), (out / "errors.md").read_text(encoding="utf-8")
    links = re.findall(r"\[([^\]]+)\]\(([^)]+)\)", told)
    links = [(text.replace("\\", ""), target) for text, target in links]  # Markdown escapes underscores
    assert [text for text, _ in links] == [row["task"] for row in rows]
    for (text, target), row in zip(links, rows, strict=True):
        address = urlsplit(target)
        assert (out / unquote(address.path)).resolve() == page.resolve()
        run = "/".join((row["domain"], row["ability"], row["protocol"], name))
        assert parse_qs(address.fragment) == {"run": [run], "task": [text]}
    refused = eai("analyze", "errors", runs, "--with", f"explorer={tmp_path / 'none.html'}", "--out", out)
    assert "no such file; eai report writes explorer.html" in refused.err


def test_a_pipeline_is_set_against_the_ability_alone(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    """One task has right goals, the other has none. A perfect second stage reaches the stated goals alone."""
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING, source=Source(data_store))
    books, toys = (
        next(task for task in suite.task_ids if task.startswith(name))
        for name in ("boxing_books", "putting_away_toys")
    )
    plans, goals = (
        answer_book("behavior", ability, data_store)
        for ability in (Ability.ACTION_SEQUENCING, Ability.GOAL_INTERPRETATION)
    )
    answers = {
        "modular": {books: plans[books].text, toys: plans[toys].text},
        "piped": {books: plans[books].text, toys: "[]"},
        "goals": {books: goals[books].text, toys: '{"node goals": []}'},
    }
    for name, given in answers.items():
        rows = [{"identifier": task, "llm_output": text} for task, text in given.items()]
        (tmp_path / name).mkdir()
        (tmp_path / name / "m_outputs.json").write_text(json.dumps(rows))
    named = ("--domain", "behavior", "--ability", "action_sequencing", "--allow-missing", "--no-explanations")
    first = tmp_path / "goals" / "m_outputs.json"
    assert eai("score", tmp_path / "modular", *named, "--out", tmp_path / "a").status == 0
    assert eai("score", tmp_path / "piped", *named, "--goals", first, "--out", tmp_path / "b").status == 0
    done = eai(
        *("analyze", "pipeline", tmp_path / "a", tmp_path / "b"),
        *("--with", f"goals={first}", "--out", tmp_path / "c", "--json"),
    )
    assert done.status == 0, done.err
    every = {row["goals"]: row for row in told_tables(done.out)["goals"]}["all"]
    assert (every["modular_numerator"], every["pipeline_numerator"]) == ("2", "1")
    found = json.loads((tmp_path / "c" / "pipeline.json").read_text())["tables"]
    rows = {row["goals"]: row for row in found["goals"]["rows"]}
    assert {
        name: [row[part]["numerator"] for part in ("modular", "pipeline", "perfect stage 2")]
        for name, row in rows.items()
    } == {"exactly right": [1, 1, 1], "some missing": [1, 0, 0], "all": [2, 1, 1]}
    assert found["missed"]["rows"][0]["tasks"] == 1
    assert {file.name for file in (tmp_path / "c").iterdir()} == {
        *(f"{name}.csv" for name in ("stages", "goals", "stage_1", "missed")),
        *("pipeline.json", "pipeline.md"),
    }
    for wrong, why in (
        (("analyze", "pipeline", tmp_path / "a"), "expected records of a pipeline"),
        (("score", tmp_path / "modular", *named, "--goals", tmp_path / "none"), "no such file or folder"),
    ):
        refused = eai(*wrong)
        assert refused.status == 2
        assert why in refused.err


def test_an_option_of_all_studies_belongs_to_one_of_them(eai: Command, tmp_path: Path) -> None:
    """The option may begin with the name of its study, as for a single study."""
    runs, out = write_runs(tmp_path / "runs", [action_run("first")]), tmp_path / "all"
    arguments = ("analyze", "all", runs, "--no-plots", "--out", out, "--with")
    refused = eai(*arguments, "exampels=0")
    assert refused.status == 2
    assert "--with exampels=0: no study of all has this option; did you mean examples?" in refused.err
    assert not out.exists()
    assert eai(*arguments, "errors.examples=0").status == 0
    assert read_table(out / "errors" / "examples.csv") == []
