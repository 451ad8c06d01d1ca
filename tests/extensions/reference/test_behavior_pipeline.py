"""The published pipelines of seven models: their answers scored here, and every difference accounted for."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import NO_ROW, score_run
from eai.results.options import ScoringOptions
from eai.results.paper_tables import map_files_to_paper_models, read_paper_table
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.summary import compute_metric_rates
from eai.results.table import Estimate
from eai.studies.pipeline.analysis import _RunsWithTrueAndInterpretedGoals, merge_run_pairs
from eai.studies.pipeline.stage_one import make_interpreted_goals_for_prompts
from eai.tasks.source import Source
from oracle import PIPELINE_MODELS, read_oracle

PHYSICS, READING = "physics", "reading"
DIFFERENCES = {
    ("claude-3-opus-20240229", "brushing_lint_off_clothing"): PHYSICS,
    ("claude-3-opus-20240229", "rearranging_furniture"): PHYSICS,
    ("cohere-command-r", "installing_a_scanner"): READING,
    ("cohere-command-r", "moving_boxes_to_storage"): READING,
    ("cohere-command-r", "rearranging_furniture"): PHYSICS,
    ("cohere-command-r", "vacuuming_floors"): READING,
    ("gemini-1.5-pro-preview-0409", "brushing_lint_off_clothing"): PHYSICS,
    ("gemini-1.5-pro-preview-0409", "rearranging_furniture"): PHYSICS,
    ("gpt-3.5-turbo-0125", "rearranging_furniture"): PHYSICS,
    ("gpt-4o-2024-05-13", "putting_away_Halloween_decorations"): PHYSICS,
    ("gpt-4o-2024-05-13", "rearranging_furniture"): PHYSICS,
    ("llama-3-8b-chat", "putting_away_toys"): PHYSICS,
    ("mixtral-8x22b-instruct-v0.1", "organizing_school_stuff"): PHYSICS,
    ("mixtral-8x22b-instruct-v0.1", "rearranging_furniture"): PHYSICS,
}
"""Every answer whose category differs from the published one, and why.

Physics: the published verdict is from the simulator, in which an action that is possible here failed, or a
goal that holds here did not. Reading: the same formulas are unreadable there; here they are read, and name
what does not exist. No lot of an ``or`` falls otherwise.
"""


@pytest.fixture(scope="module")
def suite(data_store: DataPackStore) -> Suite:
    return open_suite(
        "behavior", Ability.SUBGOAL_DECOMPOSITION, Protocol("eai-1.0.5"), source=Source(data_store)
    )


@pytest.fixture(scope="module")
def runs(suite: Suite) -> dict[str, _RunsWithTrueAndInterpretedGoals]:
    """The two runs of each model, by model."""
    return {model: _runs(model, suite) for model in PIPELINE_MODELS}


def _runs(model: str, suite: Suite) -> _RunsWithTrueAndInterpretedGoals:
    benchmark = find_benchmark("behavior")
    first = read_oracle("behavior", "goal_interpretation", model)["records"]
    goals = model, {row["identifier"]: row["response"] or "" for row in first}
    believed = make_interpreted_goals_for_prompts(goals, benchmark, suite.source)
    alone = read_oracle("behavior", "subgoal_decomposition", model)["records"]
    piped = read_oracle("behavior", "pipeline_subgoal_decomposition", model)["tasks"]
    modular = _scored(suite, model, {row["identifier"]: row["response"] or "" for row in alone})
    second = _scored(suite, model, {row["identifier"]: row["llm_output"] or "" for row in piped})
    return _RunsWithTrueAndInterpretedGoals(
        modular, [believed.add_experiment_and_study_summaries(record) for record in second], {}, {}, {}
    )


def _scored(suite: Suite, model: str, answers: dict[str, str]) -> list[Record]:
    file = ResponseFile(model, tuple(Response(task, text) for task, text in answers.items()))
    missing = {task: NO_ROW for task in suite.task_ids if task not in answers}
    return score_run(suite, file, missing, ScoringOptions(explanations=False))


def published(model: str) -> dict[str, tuple[str, bool, bool]]:
    rows = read_oracle("behavior", "pipeline_subgoal_decomposition", model)["tasks"]
    return {
        row["identifier"]: (
            row["verdict"]["category"],
            row["verdict"]["executable"],
            row["verdict"]["task_success"],
        )
        for row in rows
        if row["llm_output"] is not None
    }


def test_published_verdicts(runs: dict[str, _RunsWithTrueAndInterpretedGoals]) -> None:
    equal: Counter[str] = Counter()
    differences = []
    for model, found in runs.items():
        theirs = published(model)
        for record in found.pipeline:
            verdict = record.verdict
            if record.task_id not in theirs or not isinstance(verdict, SubgoalVerdict):
                continue
            category, executable, success = theirs[record.task_id]
            ours = verdict.category and verdict.category.value
            equal["answers"] += 1
            equal["category"] += ours == category
            equal["executable"] += verdict.executable == executable
            equal["success"] += verdict.success == success
            if ours != category:
                activity = record.task_id.partition("_0_")[0]
                differences.append((model, activity))
                why = READING if (ours, category) == ("hallucination", "not_parseable") else PHYSICS
                assert DIFFERENCES[model, activity] == why
    assert equal == {"answers": 699, "category": 685, "executable": 696, "success": 690}
    assert differences == list(DIFFERENCES)


def test_cells_of_the_paper(runs: dict[str, _RunsWithTrueAndInterpretedGoals]) -> None:
    """Those of the pipeline: an answer that was never asked for counts as one that cannot be read."""
    paper = read_paper_table("pipeline_subgoal_decomposition")
    off = []
    for model, found in runs.items():
        rates = compute_metric_rates([r.verdict for r in found.pipeline], Ability.SUBGOAL_DECOMPOSITION)
        for place in paper.columns:
            printed = paper.find_printed_number(f"{map_files_to_paper_models()[model]} (pipeline)", place)
            ours = rates[place.metric].percent
            assert printed is not None
            assert ours is not None
            off.append(round(abs(printed - ours), 6))
    assert (len(off), sum(d == 0 for d in off), sum(d <= 1 for d in off)) == (63, 39, 55)
    assert max(off) <= 3


@pytest.mark.parametrize(
    ("verdicts", "solved"), [("published", (91, 25, 30)), ("here", (98, 27, 30))]
)  # fmt: skip
def test_where_the_loss_comes_from(
    verdicts: str, solved: tuple[int, int, int], runs: dict[str, _RunsWithTrueAndInterpretedGoals]
) -> None:
    """Pipelines lose no task with right goals, and most tasks with missing goals."""
    found = [
        runs[model] if verdicts == "here" else _as_published(runs[model], model) for model in PIPELINE_MODELS
    ]
    _, goals, _ = merge_run_pairs(found).make_tables()
    rows = {row[0]: row for row in goals.rows}
    read = {
        str(name): (row[1], *(cell.numerator for cell in row[2:4] if isinstance(cell, Estimate)))
        for name, row in rows.items()
    }
    assert read == {
        "exactly right": (212, 91, solved[0]),
        "all, and others": (112, 34, solved[1]),
        "some missing": (376, 88, solved[2]),
        "all": (700, 213, sum(solved)),
    }


def _as_published(found: _RunsWithTrueAndInterpretedGoals, model: str) -> _RunsWithTrueAndInterpretedGoals:
    """The same with the simulator's verdicts on the pipeline."""
    theirs = published(model)
    piped = []
    for record in found.pipeline:
        verdict = record.verdict
        assert isinstance(verdict, SubgoalVerdict)
        category, executable, success = theirs.get(record.task_id, ("not_parseable", False, False))
        as_theirs = SubgoalVerdict(
            category=SubgoalAnswerCategory(category),
            executable=executable,
            success=success,
            goals=verdict.goals,
        )
        piped.append(replace(record, verdict=as_theirs))
    return replace(found, pipeline=piped)
