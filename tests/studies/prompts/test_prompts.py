"""Comparison of prompts: matrices of known order, and refused runs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.results.record import Record
from eai.results.table import Estimate, Table
from eai.studies.prompts.study import PLAIN, make_prompt_tables
from eai.studies.study import choose_metric
from eai.world.fault import FaultKind
from experiments import experiment
from processes import eai as in_own_process
from results.verdicts import SUCCEEDED, failed, record
from studies.told import read_table
from suites import answer_book

SUCCESS = "task_success"
BAD = failed(FaultKind.AFFORDANCE)


def run(model: str, successes: int, tasks: int = 20) -> list[Record]:
    """A run in which the first tasks succeed."""
    verdicts = [SUCCEEDED if i < successes else BAD for i in range(tasks)]
    return [replace(record(f"t{i}", verdict), model=model) for i, verdict in enumerate(verdicts)]


def tables_of(matrix: dict[str, dict[str, int]]) -> dict[str, Table]:
    """Return the tables of a matrix: prompt -> model -> successes."""
    runs = [(prompt, run(model, n)) for prompt, row in matrix.items() for model, n in row.items()]
    return {table.name: table for table in make_prompt_tables(runs, SUCCESS)}


def rows(table: Table) -> list[dict[str, object]]:
    return table.row_dicts()


def value(cell: object) -> float | None:
    assert isinstance(cell, Estimate)
    return cell.value


@pytest.mark.parametrize(
    ("second", "tau", "w"),
    [((2, 8, 14), 1.0, 1.0), ((14, 8, 2), -1.0, 0.0), ((8, 8, 8), None, None)],
)
def test_agreement_of_models_with_known_orders_of_prompts_is_computed(
    second: Sequence[int], tau: float | None, w: float | None
) -> None:
    matrix = {
        name: {"one": n, "two": other} for name, n, other in zip("abc", (1, 6, 12), second, strict=True)
    }
    pair, together = rows(tables_of(matrix)["prompt_agreement"])
    assert value(pair["tau"]) == tau
    if w is not None:
        assert value(together["concordance"]) == pytest.approx(w)


def test_equal_results_have_no_agreement_and_no_variance() -> None:
    tables = tables_of({name: {"one": 20, "two": 20} for name in "abc"})
    pair, together = rows(tables["prompt_agreement"])
    assert value(pair["tau"]) is None
    assert value(together["concordance"]) is None
    assert [row["share"] for row in rows(tables["prompt_variance"])] == [None, None, None]
    assert {value(row["gain"]) for row in rows(tables["prompt_gains"])} == {0.0}


def test_variance_is_assigned_to_models_prompts_or_the_rest() -> None:
    tables = tables_of({name: {"one": n, "two": n} for name, n in zip("abc", (1, 6, 12), strict=True)})
    assert [row["share"] for row in rows(tables["prompt_variance"])] == pytest.approx([0.0, 1.0, 0.0])


def test_gains_are_paired_by_task_and_corrected_for_the_number_of_prompts() -> None:
    found = rows(tables_of({"base": {"one": 4}, "better": {"one": 14}, "same": {"one": 4}})["prompt_gains"])
    better, same = found
    assert (value(better["gain"]), better["best"], same["best"]) == (50.0, True, False)
    assert better["p"] == pytest.approx(2 / 2**10)
    assert better["p_holm"] == pytest.approx(4 / 2**10)
    assert same["p_holm"] == 1.0


def test_results_count_only_tasks_that_all_runs_share() -> None:
    runs = [("a", run("m", 5)), ("b", run("m", 5, tasks=10))]
    cells = rows({t.name: t for t in make_prompt_tables(runs, SUCCESS)}["prompts"])
    assert [value(row["value"]) for row in cells] == [50.0, 50.0]
    assert {value(row["format_errors"]) for row in cells} == {0.0}


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ([("a", run("m", 1))], "two prompts or more"),
        ([("a", run("m", 1)), ("b", run("n", 1))], "n has no run with the prompts a"),
    ],
)
def test_runs_that_form_no_matrix_are_refused(runs: list[tuple[str, list[Record]]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_prompt_tables(runs, SUCCESS)


def test_unknown_metrics_and_references_are_refused() -> None:
    runs = [("a", run("m", 1)), ("b", run("m", 2))]
    with pytest.raises(InputError, match="metric=luck: expected one of"):
        choose_metric(Ability.ACTION_SEQUENCING, "luck")
    with pytest.raises(InputError, match="reference=c: expected one of a, b"):
        make_prompt_tables(runs, SUCCESS, "c")


def test_answers_scored_with_prompt_names_are_analysed(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    book = answer_book("behavior", Ability.GOAL_INTERPRETATION, data_store)
    for name, kept in (("base", 1), ("general", 2)):
        answers = []
        for number, task_id in enumerate(book):
            gold = book[task_id]
            answers.append({"identifier": task_id, "llm_output": gold.text if number % 3 < kept else "{}"})
        file = tmp_path / name / "m_outputs.json"
        file.parent.mkdir()
        file.write_text(json.dumps(answers), encoding="utf-8")
        suite = ("--domain", "behavior", "--ability", "goal_interpretation")
        named = ("--prompt-name", name, "--out", tmp_path / "scores" / name)
        assert eai("score", file, *suite, *named).status == 0
    summary = json.loads((tmp_path / "scores" / "base" / "summary.json").read_text())
    assert summary["study"]["prompts"]["options"] == {"prompt_name": "base"}
    outcome = eai(
        "analyze", "prompts", tmp_path / "scores", "--with", "reference=base", "--out", tmp_path / "out"
    )
    assert outcome.status == 0
    assert "4 tables, 1 plot; in " in outcome.out
    (folder,) = (tmp_path / "out").iterdir()
    again = ("--with", "reference=base", "--no-plots", "--json", "--out", tmp_path / "again")
    (told,) = json.loads(eai("analyze", "prompts", tmp_path / "scores", *again).out)
    (row,) = read_table(Path(told["folder"]) / "prompt_gains.csv")
    assert (told["prompts"], told["models"]) == (["base", row["prompt"]], ["m"])
    found = json.loads((folder / "prompts.json").read_text())["tables"]
    (gain,) = found["prompt_gains"]["rows"]
    assert (gain["prompt"], gain["best"]) == ("general", True)
    assert gain["p"] < 0.01
    assert float(row["p"]) == gain["p"]
    assert (folder / "prompts.svg").exists()


def test_the_label_of_a_run_contains_the_name_of_its_prompts(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    pytest.importorskip("inspect_ai")
    suite = ("--domain", "behavior", "--ability", "goal_interpretation", "--limit", "2", "--out", tmp_path)
    for name in (("--with", "prompts.name=base"), ("--with", "prompts.name=general"), ()):
        assert in_own_process("run", "--model", "eai/oracle", *suite, *name).status == 0
    folder = tmp_path / "behavior" / "goal_interpretation" / "eai_oracle"
    assert sorted(path.parent.relative_to(folder).as_posix() for path in folder.rglob("summary.json")) == [
        ".",
        "prompt-base",
        "prompt-general",
    ]
    records = (folder / "prompt-base" / "records.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["study"]["prompts"]["label"] for line in records] == ["prompt-base"] * 2
    assert "prompts_sha256" in json.loads((folder / "summary.json").read_text())["run"]
    outcome = in_own_process("analyze", "prompts", tmp_path, "--no-plots", "--out", tmp_path / "out")
    assert "4 tables, 0 plots; in " in outcome.out
    assert PLAIN in next((tmp_path / "out").rglob("prompts.md")).read_text(encoding="utf-8")
    assert experiment(prompt_name="base").label == "prompt-base"


@pytest.mark.parametrize("place", [0, 3])
def test_a_run_without_answers_counts_as_0_in_all_draws_of_tasks(place: int) -> None:
    """No answer adds to the metric of such a run, wherever it stands in the order of runs."""
    runs = [(name, run(model, n)) for model, name, n in (("one", "a", 12), ("two", "b", 16), ("two", "a", 2))]
    dead = [replace(record, model="one", unanswered="server down") for record in run("one", 0)]
    runs.insert(place, ("b", dead))
    agreement, _ = rows(
        {table.name: table for table in make_prompt_tables(runs, SUCCESS)}["prompt_agreement"]
    )
    assert agreement["tau"] == Estimate(-1.0, -1.0, -1.0)
