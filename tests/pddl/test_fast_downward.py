"""Fast Downward in private folders; skipped where the extra ``planner`` is not installed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Lock

import pytest

from eai.base.errors import DataError
from eai.base.store import DataPackStore
from eai.benchmarks.published import open_behavior_transition_tasks, open_virtualhome_transition_tasks
from eai.logic.formula import Atom
from eai.pddl import fast_downward, limited
from eai.pddl.check import PddlDeclarations, check_action
from eai.pddl.execute import PlanStep
from eai.pddl.fast_downward import FastDownward, hold_permit_to_call_planner, measure_machine_memory_mib
from eai.pddl.planning import PlannerOutcome, PlanningTask
from eai.pddl.reader import read_action, read_domain, read_problem
from eai.pddl.search import BuiltInPlanner
from eai.planning.search import Limits
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source
from processes import wait_until, working_in

COUNTER = 18
"""Bits of a counter that has to be counted to its end: more than a second of work for any search."""


@pytest.fixture(scope="module")
def planner() -> FastDownward:
    return installed(cpu_seconds=30)


def installed(cpu_seconds: int = 100) -> FastDownward:
    try:
        return FastDownward.find_installed(cpu_seconds)
    except DataError as error:
        pytest.skip(str(error))


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only place for temporary files."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def made_up(actions: str, goal: str = "(done)", init: str = "(ready)") -> PlanningTask:
    domain = read_domain(
        f"(define (domain m) (:constants k) (:predicates (ready) (done) (never) (held ?x)) {actions})"
    )
    return PlanningTask(
        domain, read_problem(f"(define (problem p) (:domain m) (:init {init}) (:goal {goal}))")
    )


def counter_text(bits: int) -> tuple[str, str]:
    names = [f"(b{i})" for i in range(bits)]
    actions = "".join(
        f"(:action up{i} :precondition (and (not (b{i})) {' '.join(names[:i])})"
        f" :effect (and (b{i}) {' '.join(f'(not {name})' for name in names[:i])}))"
        for i in range(bits)
    )
    domain = f"(define (domain c) (:predicates {' '.join(names)}) {actions})"
    return domain, f"(define (problem p) (:domain c) (:init) (:goal (and {' '.join(names)})))"


def counter(bits: int) -> PlanningTask:
    domain, problem = counter_text(bits)
    return PlanningTask(read_domain(domain), read_problem(problem))


def test_a_plan_is_found_executed_and_nothing_is_left_behind(planner: FastDownward, scratch: Path) -> None:
    result = planner.solve(made_up("(:action do :parameters (?x) :precondition (ready) :effect (done))"))
    assert (result.outcome, result.plan) == (PlannerOutcome.SOLVED, (PlanStep("do", ("k",)),))
    assert planner.version in result.detail
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize(
    ("actions", "goal", "outcome"),
    [
        ("(:action do :precondition (never) :effect (done))", "(done)", PlannerOutcome.UNSOLVABLE),
        ("(:action do :precondition (or) :effect (done))", "(done)", PlannerOutcome.UNSOLVABLE),
        ("(:action do :precondition (ready) :effect (dark))", "(done)", PlannerOutcome.INPUT_ERROR),
        ("(:action do :precondition (held ?x) :effect (done))", "(done)", PlannerOutcome.INPUT_ERROR),
        ("", "(and)", PlannerOutcome.SOLVED),
        (
            "(:action do :parameters (?x) :effect (and (when (held ?x) (done)) (held ?x)))",
            "(done)",
            PlannerOutcome.SOLVED,
        ),
    ],
)
def test_outcomes(planner: FastDownward, actions: str, goal: str, outcome: PlannerOutcome) -> None:
    assert planner.solve(made_up(actions, goal)).outcome is outcome


def test_the_limit_of_time_is_an_outcome(scratch: Path) -> None:
    result = installed(cpu_seconds=1).solve(counter(COUNTER + 6))
    assert result.outcome in {PlannerOutcome.TIME, PlannerOutcome.MEMORY}
    assert list(scratch.iterdir()) == []


def test_the_limit_of_memory_is_an_outcome() -> None:
    result = replace(installed(cpu_seconds=30), memory_mib=60).solve(counter(COUNTER))
    assert result.outcome is PlannerOutcome.MEMORY


def test_a_fatal_atom_counts_as_a_crash_only_where_it_is_reachable(planner: FastDownward) -> None:
    text = "(:action do :precondition {} :effect (and (held k) (done)))(:action other :effect (done))"
    for condition, outcome in (("(ready)", PlannerOutcome.CRASH), ("(never)", PlannerOutcome.SOLVED)):
        task = made_up(text.format(condition))
        watched = PlanningTask(task.domain, task.problem, fatal=Atom("held"))
        assert planner.solve(watched).outcome is outcome


def test_many_calls_at_once_do_not_clash(planner: FastDownward, scratch: Path) -> None:
    tasks = [counter(bits) for bits in (1, 2, 3, 4)] * 2
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(planner.solve, tasks))
    assert [len(result.plan) for result in results] == [1, 3, 7, 15] * 2
    assert list(scratch.iterdir()) == []


def test_a_missing_planner_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fast_downward.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(DataError, match=r"pip install 'eai-bench\[planner\]'"):
        FastDownward.find_installed()


CHILD = """
from eai.pddl.fast_downward import FastDownward
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import read_domain, read_problem
domain, problem = {texts!r}
print("started", flush=True)
planner = FastDownward.find_installed(cpu_seconds=60)
planner.solve(PlanningTask(read_domain(domain), read_problem(problem)))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_process_outlives_an_interrupt(tmp_path: Path, number: signal.Signals) -> None:
    installed()
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD.format(texts=counter_text(COUNTER + 8))],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"started\n"
        assert wait_until(lambda: working_in(tmp_path)), "the planner never started"
        process.send_signal(number)
        process.communicate(timeout=600)
        assert wait_until(lambda: not working_in(tmp_path)), "a planner is still alive"
        if number is signal.SIGINT:
            assert list(tmp_path.iterdir()) == []
    finally:
        process.kill()
        process.communicate()


def test_a_launcher_whose_parent_has_ended_starts_nothing(tmp_path: Path) -> None:
    made = tmp_path / "made"
    for parent, starts in ((os.getpid(), True), (os.getpid() + 1, False)):
        made.unlink(missing_ok=True)
        limits = (str(parent), "10", str(1 << 30))
        done = subprocess.run(
            [sys.executable, "-I", limited.__file__, *limits, "/usr/bin/env", "touch", str(made)], check=False
        )
        assert (done.returncode == 0, made.exists()) == (starts, starts)


def full_task(task: TransitionTask) -> PlanningTask:
    """Return the problem of a task with all operators of its domain that PDDL permits."""
    header = task.domain.header
    operators = [read_action(text.write_pddl) for text in task.domain.operators.values()]
    allowed = tuple(
        [each for each in operators if not check_action(each, PddlDeclarations.from_domain(header))]
    )
    return PlanningTask(replace(header, actions=allowed), task.problem)


def test_both_planners_agree_on_a_sample_and_the_second_decides_the_rest(
    data_store: DataPackStore, planner: FastDownward
) -> None:
    virtualhome = list(open_virtualhome_transition_tasks(Source(data_store)).values())
    behavior = list(open_behavior_transition_tasks(Source(data_store)).values())
    for task in (*virtualhome[::40], *behavior[::25]):
        made = full_task(task)
        reports = [each.solve(made).outcome for each in (BuiltInPlanner(), planner)]
        assert reports == [PlannerOutcome.SOLVED, PlannerOutcome.SOLVED], task.id
        kept = tuple(action for action in made.domain.actions if action.name != task.operators[0])
        without = PlanningTask(replace(made.domain, actions=kept), made.problem)
        first, second = (each.solve(without).outcome for each in (BuiltInPlanner(), planner))
        assert first in {second, PlannerOutcome.TIME}, task.id
    hard = next(task for task in behavior if task.id.startswith("serving_a_meal"))
    assert BuiltInPlanner(Limits(0)).solve(full_task(hard)).outcome is PlannerOutcome.TIME
    tiered = BuiltInPlanner(Limits(0), planner).solve(full_task(hard))
    assert tiered.outcome is PlannerOutcome.SOLVED
    assert "Fast Downward" in tiered.detail


def test_no_more_planners_run_at_a_time_than_there_are_seats(tmp_path: Path) -> None:
    lock, running, most = Lock(), 0, 0

    def work(number: int) -> int:
        nonlocal running, most
        with hold_permit_to_call_planner(3, tmp_path):
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
        with hold_permit_to_call_planner(1, tmp_path):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    with hold_permit_to_call_planner(1, tmp_path):
        pass


def test_the_machine_has_memory() -> None:
    assert measure_machine_memory_mib() > 64
