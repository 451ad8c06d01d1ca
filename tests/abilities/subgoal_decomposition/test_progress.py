from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.virtualhome import flat
from eai.abilities.subgoal_decomposition.progress import GoalProgress, StateTest
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.errors import InputError
from eai.logic import semantics
from eai.logic.ltl import parse
from eai.logic.signature import Signature
from eai.logic.trace import TakenAction, Trace
from eai.world.execution import Action, execute
from eai.world.state import State

START = flat.state()
SCENE = START.scene
SIGNATURE = Signature(
    {p.name: p.arity for p in SCENE.vocabulary.predicates},
    {op.name: op.arity for op in virtualhome.as_meant().operators},
)
STEPS = (
    "WALK fridge.10",
    "OPEN fridge.10",
    "CLOSE fridge.10",
    "GRAB milk.11",
    "WALK bed.20",
    "SIT bed.20",
    "STANDUP",
)
ATOMS = (
    "OPEN(fridge.10)",
    "CLOSED(fridge.10)",
    "HOLDS_RH(character.65, milk.11)",
    "SITTING(character.65)",
    "not OPEN(fridge.10)",
    "exists x. (GRAB(x))",
    "exists x. (exists y. (NEXT_TO(x, y) and WALK(y)))",
    "exists x. (OPEN(x) or CLOSE(x))",
    "WALK(bed.20)",
    "forall x. (not GRAB(x))",
)
GOALS = st.lists(
    st.lists(st.sampled_from(ATOMS), min_size=1, max_size=2).map(" and ".join), min_size=1, max_size=3
).map(" then ".join)


class Seen:
    """A state as the logic's evaluator asks for it."""

    def __init__(self, state: State) -> None:
        self.state = state

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        return self.state.has(predicate, *(SCENE.index[name] for name in arguments))

    def objects(self, category: str | None) -> Sequence[str]:
        return SCENE.names(SCENE.category(category))


@settings(deadline=None)
@given(GOALS, st.lists(st.sampled_from(STEPS), max_size=8))
def test_progress_agrees_with_the_semantics_of_formulas(goal: str, steps: list[str]) -> None:
    formula = parse(goal, SIGNATURE).formula
    plan = [flat.action(step, SCENE) for step in steps]
    trajectory = execute(virtualhome.as_meant(), START, plan)
    progress = GoalProgress(formula, SCENE)
    met = 0
    for state, action in zip(trajectory.states, trajectory.executed, strict=False):
        met = progress.advance(met, state, action)
    taken = [
        TakenAction(a.operator, tuple(SCENE.objects[i].name for i in a.arguments))
        for a in trajectory.executed
    ]
    expected = semantics.holds(formula, Trace([Seen(s) for s in trajectory.states], taken))
    assert progress.reached(met, trajectory.final) == expected


def test_one_position_meets_one_part() -> None:
    progress = GoalProgress(parse("CLOSED(fridge.10) then CLOSED(fridge.10)").formula, SCENE)
    assert not progress.reached(0, START)
    assert progress.reached(progress.advance(0, START, Action("STANDUP", ())), START)


def test_a_goal_is_a_sequence_of_state_formulas() -> None:
    with pytest.raises(InputError, match="sequence of state formulas"):
        GoalProgress(parse("(p(a) then q(a)) and r(a)").formula, SCENE)


def test_a_formula_is_tested_on_one_state() -> None:
    test = StateTest(parse("exists x. (ONTOP(cup.13, x) and DIRTY(x))").formula, SCENE)
    assert test(START)
    assert not test(flat.state("-DIRTY table.12", over=SCENE))
