"""How often planners are called: the choice of planner, and equal operators of several models."""

from __future__ import annotations

from pathlib import Path

import pytest

from counted_planner import CountedPlanner
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planners import make_planner
from eai.pddl.planning import PlannerChoice, PlannerLimits, PlannerOutcome, PlanningTask
from eai.pddl.reader import read_domain, read_problem
from eai.results.batch import Scoring, map_unanswered_tasks_to_reason
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.tasks.source import Source
from pddl.test_fast_downward import counter
from suites import answer_book

UNDECIDED = counter(12)
"""A task with more states than the built-in search may evaluate before Fast Downward is called."""


def door(goal: str) -> PlanningTask:
    domain = read_domain("(define (domain d) (:predicates (open) (lit)) (:action push :effect (open)))")
    return PlanningTask(domain, read_problem(f"(define (problem p) (:domain d) (:init) (:goal {goal}))"))


@pytest.mark.parametrize("choice", [PlannerChoice.AUTO, PlannerChoice.FULL])
def test_fast_downward_is_called_only_if_the_built_in_search_is_undecided(
    choice: PlannerChoice, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = CountedPlanner(tmp_path, monkeypatch)
    planner = make_planner(choice, 100)
    assert planner is not None
    for task, outcome, calls in (
        (door("(open)"), PlannerOutcome.SOLVED, 0),
        (door("(lit)"), PlannerOutcome.UNSOLVABLE, 0),
        (UNDECIDED, PlannerOutcome.UNSOLVABLE, 1),
    ):
        assert (planner.solve(task).outcome, counted.calls) == (outcome, calls)


@pytest.mark.parametrize("workers", [1, 3])
def test_equal_operators_are_planned_once_for_all_models(
    workers: int, data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = CountedPlanner(tmp_path, monkeypatch)
    limits = PlannerLimits(folder=tmp_path / "shared")
    source = Source(data_store, planner=PlannerChoice.FAST_DOWNWARD, terms=limits)
    suite = open_suite("behavior", Ability.TRANSITION_MODELING, source=source)
    gold = answer_book("behavior", Ability.TRANSITION_MODELING, data_store)
    lines = []
    with Scoring(workers) as scoring:
        for model in ("first", "second", "third"):
            answers = ResponseFile(model, tuple(Response(i, gold[i].text) for i in suite.task_ids[:9]))
            missing = map_unanswered_tasks_to_reason(suite, answers)
            batches = scoring.score_in_batches(suite, answers, missing, ScoringOptions())
            lines.append(b"".join(batch for batch, _ in batches).replace(model.encode(), b"model"))
            assert counted.calls == 9
    assert lines[0] == lines[1] == lines[2]


def test_equal_tasks_of_planners_with_other_limits_are_planned_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = CountedPlanner(tmp_path, monkeypatch)
    for seconds, calls in ((100, 1), (100, 1), (200, 2)):
        planner = make_planner(PlannerChoice.FAST_DOWNWARD, seconds, PlannerLimits(folder=tmp_path / "new"))
        assert planner is not None
        assert planner.solve(UNDECIDED).outcome is PlannerOutcome.UNSOLVABLE
        assert counted.calls == calls
