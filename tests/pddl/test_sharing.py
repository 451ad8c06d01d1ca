from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

import pytest

from eai.logic.formula import Atom
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlannerOutcome, PlannerResult, PlanningTask
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.sharing import Seats, SharedPlanner, machine_memory_mib

RESULTS = (
    PlannerResult(PlannerOutcome.SOLVED, (PlanStep("do", ("k", "k")), PlanStep("rest", ())), "found"),
    PlannerResult(PlannerOutcome.TIME, detail="too long"),
)


@dataclass
class Counting:
    """A planner that counts how often it is asked."""

    name: str = "counting"
    result: PlannerResult = RESULTS[0]
    calls: int = 0

    def solve(self, task: PlanningTask) -> PlannerResult:
        self.calls += 1
        return self.result


def task(goal: str = "(done)", fatal: Atom | None = None) -> PlanningTask:
    domain = read_domain("(define (domain d) (:predicates (done) (ready)))")
    problem = read_problem(f"(define (problem p) (:domain d) (:init) (:goal {goal}))")
    return PlanningTask(domain, problem, fatal)


@pytest.mark.parametrize("result", RESULTS)
def test_a_problem_is_planned_with_once_in_all_processes(tmp_path: Path, result: PlannerResult) -> None:
    first, second = Counting(result=result), Counting(result=result)
    assert [SharedPlanner(each, tmp_path).solve(task()) for each in (first, second, first)] == [result] * 3
    assert (first.calls, second.calls) == (1, 0)
    assert SharedPlanner(first, tmp_path).name == "counting"


def test_another_goal_planner_or_fatal_atom_is_another_problem(tmp_path: Path) -> None:
    planner = Counting()
    for each in (task(), task("(ready)"), task(fatal=Atom("done"))):
        SharedPlanner(planner, tmp_path).solve(each)
    SharedPlanner(Counting("another"), tmp_path).solve(task())
    assert planner.calls == 3
    assert len(list(tmp_path.glob("*.json"))) == len(list(tmp_path.iterdir())) == 4


def test_no_more_planners_run_at_a_time_than_there_are_seats(tmp_path: Path) -> None:
    lock, running, most = Lock(), 0, 0

    def work(number: int) -> int:
        nonlocal running, most
        with Seats(3, tmp_path).taken():
            with lock:
                running += 1
                most = max(most, running)
            total = sum(range(200_000))
            with lock:
                running -= 1
        return total

    with ThreadPoolExecutor(30) as pool:
        assert len(list(pool.map(work, range(30)))) == 30
    assert 1 <= most <= 3


def test_a_seat_is_given_back_by_whoever_fails(tmp_path: Path) -> None:
    def fail() -> None:
        with Seats(1, tmp_path).taken():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    with Seats(1, tmp_path).taken():
        pass


def test_the_machine_has_memory() -> None:
    assert machine_memory_mib() > 64
