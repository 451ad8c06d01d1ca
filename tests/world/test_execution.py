from __future__ import annotations

import pytest

from eai.logic.formula import TRUE
from eai.logic.ltl import parse, read_formula
from eai.logic.semantics import explain_truth, holds
from eai.logic.signature import FormulaSignature
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import describe_fault, execute_plan, to_trace
from eai.world.fault import FaultKind
from eai.world.operator import Operator, OperatorAlternative, missing_step
from world import toy


def plan(*steps: str) -> list[Action]:
    """Return the actions of texts such as ``LIFT red``."""
    index = toy.initial().scene.index
    split = [step.split() for step in steps]
    return [Action(name, tuple(index[o] for o in objects)) for name, *objects in split]


def test_a_plan_runs_to_its_end() -> None:
    trajectory = execute_plan(
        toy.DOMAIN, toy.initial(), plan("LIFT red", "GO shed", "DROP red", "PRESS lamp")
    )
    assert trajectory.failure is None
    assert len(trajectory.states) == 5
    index = trajectory.final_state.scene.index
    assert trajectory.final_state.has("at", index["red"], index["shed"])
    assert not trajectory.final_state.has("at", index["red"], index["hall"])
    assert trajectory.final_state.has("lit", index["lamp"])


@pytest.mark.parametrize(
    ("steps", "kind", "earlier"),
    [
        (["PRESS red"], FaultKind.AFFORDANCE, None),
        (["PRESS lamp"], FaultKind.MISSING_STEP, None),
        (["GO shed", "LIFT blue", "GO hall", "PRESS lamp"], FaultKind.WRONG_ORDER, 2),
        (["LIFT red", "DROP red", "DROP red"], FaultKind.WRONG_ORDER, 1),
        (["LIFT red", "LIFT red"], FaultKind.WRONG_ORDER, 0),
        (["DROP blue"], FaultKind.MISSING_STEP, None),
    ],
)
def test_the_first_failing_step_is_diagnosed(steps: list[str], kind: FaultKind, earlier: int | None) -> None:
    trajectory = execute_plan(toy.DOMAIN, toy.initial(), [*plan(*steps), *plan("GO shed")])
    assert trajectory.failure is not None
    assert (trajectory.failure.kind, trajectory.failure.earlier) == (kind, earlier)
    assert len(trajectory.steps) == len(steps), "what follows a fatal step is not tried"
    assert len(trajectory.states) == len(steps)


def test_a_wrong_order_names_the_state_in_which_its_own_check_passed() -> None:
    checks = missing_step(toy.holding(toy.X), "{x} is not held"), toy.BESIDE
    wipe = Operator(
        "WIPE", (toy.X,), (), (), alternatives=tuple(OperatorAlternative(TRUE, (c,), ()) for c in checks)
    )
    domain = Domain("wiping", toy.VOCABULARY, (*toy.DOMAIN.operators, wipe))
    steps = plan("LIFT red", "DROP red", "GO shed", "WIPE red")
    assert execute_plan(domain, toy.initial(), steps).failure == Fault(FaultKind.WRONG_ORDER, checks[0], 1)


def test_an_additional_step_is_skipped_and_counted() -> None:
    trajectory = execute_plan(toy.DOMAIN, toy.initial(), plan("GO hall", "GO shed", "GO shed", "PRESS lamp"))
    assert trajectory.failure is None
    assert trajectory.needless_step_count == 2
    assert [action.operator for action in trajectory.executed_actions] == ["GO", "PRESS"]


def test_a_fault_is_described_with_the_names_of_its_objects() -> None:
    trajectory = execute_plan(toy.DOMAIN, toy.initial(), plan("PRESS lamp"))
    assert trajectory.failure is not None
    action = trajectory.steps[0].action
    assert (
        describe_fault(trajectory.failure, toy.DOMAIN, action, toy.initial().scene)
        == "the robot is not beside lamp"
    )


def test_an_empty_plan_changes_nothing() -> None:
    initial = toy.initial()
    trajectory = execute_plan(toy.DOMAIN, initial, [])
    assert trajectory.states == (initial,)
    assert trajectory.failure is None


def test_a_prefix_of_a_trajectory_ends_with_the_state_after_its_last_step() -> None:
    whole = execute_plan(toy.DOMAIN, toy.initial(), plan("GO hall", "GO shed", "GO shed", "PRESS lamp"))
    assert len(whole.executed_actions) == 2
    for executed in range(len(whole.executed_actions) + 1):
        part = whole.prefix(executed)
        assert part.executed_actions == whole.executed_actions[:executed]
        assert part.states == whole.states[: executed + 1]
        assert part.final_state is whole.states[executed]


START = toy.initial()
ROBOT, HALL, SHED, RED, BLUE, LAMP = range(6)
PLAN = (Action("LIFT", (RED,)), Action("LIFT", (RED,)), Action("GO", (SHED,)), Action("PRESS", (LAMP,)))
TIMELINE = to_trace(execute_plan(toy.DOMAIN, START, PLAN[::2]))
SIGNATURE = FormulaSignature({"at": 2, "holding": 1, "lit": 1, "beside": 1}, {"GO": 1, "LIFT": 1})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("holding(red) then at(red, shed)", True),
        ("LIFT(red) then GO(shed)", True),
        ("GO(shed) then LIFT(red)", False),
        ("beside(blue)", True),
        ("beside(red) then beside(lamp)", True),
        ("beside(lamp) then beside(red) then beside(red)", False),
        ("forall x:box. (at(x, shed))", True),
        ("exists x. (lit(x))", False),
        ("at(red, moon)", False),
        ("flies(red)", False),
        ("at(red)", False),
    ],
)
def test_formulas_are_evaluated_on_the_executed_steps(text: str, expected: bool) -> None:
    assert holds(read_formula(text, SIGNATURE)[0], TIMELINE) is expected


def test_evidence_counts_executed_steps_only() -> None:
    evidence = explain_truth(parse("holding(red) then (at(red, shed) and lit(lamp))"), TIMELINE)
    assert (evidence.holds, evidence.positions) == (False, (1,))
    assert evidence.failed == (parse("lit(lamp)"),)


def test_skipped_and_failed_steps_are_not_part_of_the_trace() -> None:
    failed = to_trace(execute_plan(toy.DOMAIN, START, (Action("DROP", (RED,)),)))
    assert failed.length == 1
    assert not holds(read_formula("DROP(red)", FormulaSignature({}, {"DROP": 1}))[0], failed)
