from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.abilities.subgoal_decomposition.progress import GoalProgress, StateTest
from eai.errors import InputError
from eai.households.virtualhome import domain as virtualhome
from eai.logic import semantics
from eai.logic.formula import Constant, Equals, Formula, Term, Then, Variable
from eai.logic.ltl import parse
from eai.logic.rewriting import Leaf, rewrite
from eai.logic.signature import Signature
from eai.logic.trace import TakenAction
from eai.world.execution import Action, Step, Trajectory, execute
from eai.world.state import Scene, WorldObject
from eai.world.timeline import timeline
from eai.world.vocabulary import Predicate, Vocabulary
from households.virtualhome import flat
from logic.naive import Facts
from logic.random_formulas import PREDICATES, formulas, traces
from logic.random_formulas import SCENE as OBJECTS_OF_SCENE
from sweeps import examples
from threading_tests import asked_by_threads

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


def assert_progress_agrees(formula: Formula, trajectory: Trajectory) -> None:
    progress = GoalProgress(formula, trajectory.states[0].scene)
    met = 0
    for state, action in zip(trajectory.states, trajectory.executed, strict=False):
        met = progress.advance(met, state, action)
    assert progress.reached(met, trajectory.final) == semantics.holds(formula, timeline(trajectory))


@settings(deadline=None)
@given(GOALS, st.lists(st.sampled_from(STEPS), max_size=8))
def test_progress_agrees_with_the_semantics_of_formulas(goal: str, steps: list[str]) -> None:
    plan = [flat.action(step, SCENE) for step in steps]
    trajectory = execute(virtualhome.as_meant(), START, plan)
    assert_progress_agrees(parse(goal, SIGNATURE).formula, trajectory)


def in_scene(formula: Formula, scene: Scene) -> Formula:
    """A random formula about objects that there are; what would compare an action's objects does not."""

    def known(leaf: Leaf, bound: frozenset[str]) -> Formula:
        if isinstance(leaf, Equals):
            return Equals(*(of_scene(term) for term in (leaf.left, leaf.right)))
        return replace(leaf, arguments=tuple([of_scene(term) for term in leaf.arguments]))

    def of_scene(term: Term) -> Term:
        is_known = isinstance(term, Variable) or term.name in scene.index
        return term if is_known else Constant(scene.objects[len(term.name) % len(scene.objects)].name)

    return rewrite(formula, known)


@settings(deadline=None, max_examples=examples(400))
@given(st.lists(formulas(temporal=False), min_size=1, max_size=3), traces())
def test_progress_agrees_on_random_formulas_and_trajectories(
    parts: list[Formula], random_trajectory: tuple[list[Facts], list[TakenAction]]
) -> None:
    states, actions = random_trajectory
    scene = Scene(
        Vocabulary(tuple(Predicate(name, arity) for name, arity in PREDICATES.items())),
        [WorldObject(name, category) for name, category in OBJECTS_OF_SCENE],
    )

    def indices(names: Sequence[str]) -> tuple[int, ...]:
        return tuple([scene.index[name] for name in names])

    trajectory = Trajectory(
        tuple(scene.state((name, indices(names)) for name, names in state.true) for state in states),
        tuple(Step(Action(action.name, indices(action.arguments)), None) for action in actions),
    )
    made = [in_scene(part, scene) for part in parts]
    assert_progress_agrees(made[0] if len(made) == 1 else Then(tuple(made)), trajectory)


def test_one_position_meets_one_part() -> None:
    progress = GoalProgress(parse("CLOSED(fridge.10) then CLOSED(fridge.10)").formula, SCENE)
    assert not progress.reached(0, START)
    assert progress.reached(progress.advance(0, START, Action("STANDUP", ())), START)


def test_what_must_hold_at_the_end_is_asked_there() -> None:
    is_open = StateTest(parse("OPEN(fridge.10)").formula, SCENE)
    progress = GoalProgress(parse("CLOSED(fridge.10)").formula, SCENE, is_open)
    assert not progress.reached(0, START)
    assert progress.reached(1, flat.state("OPEN fridge.10", over=SCENE))
    assert not progress.reached(1, START)


def test_a_goal_is_a_sequence_of_state_formulas() -> None:
    with pytest.raises(InputError, match="sequence of state formulas"):
        GoalProgress(parse("(p(a) then q(a)) and r(a)").formula, SCENE)


def test_a_formula_is_tested_on_one_state() -> None:
    test = StateTest(parse("exists x. (ONTOP(cup.13, x) and DIRTY(x))").formula, SCENE)
    assert test(START)
    assert not test(flat.state("-DIRTY table.12", over=SCENE))


def test_many_threads_may_ask_one_test() -> None:
    on = "exists y. (exists z. (ONTOP(x, y) and y = z))"
    test = StateTest(parse(f"forall x. (({on}) or not ({on}))").formula, SCENE)
    assert asked_by_threads(lambda i: test(START), 1_000)
