from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.virtualhome import flat
from eai.abilities.subgoal_decomposition.program import (
    CheckSubgoalHoldsInstruction,
    ExecuteSubgoalPlansInstruction,
    Instruction,
    SubgoalForkInstruction,
    SubgoalPlanningResult,
)
from eai.abilities.subgoal_decomposition.search import (
    ExplorationLimits,
    ExplorationResult,
    GoalProgress,
    explore_subgoal_program,
)
from eai.base.errors import InputError
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.logic import semantics
from eai.logic.formula import (
    FALSE,
    TRUE,
    And,
    Atom,
    Constant,
    Equals,
    Exists,
    Formula,
    Leaf,
    Occurs,
    Term,
    Then,
    Variable,
)
from eai.logic.ltl import parse, read_formula
from eai.logic.rewriting import rewrite_leaves
from eai.logic.signature import FormulaSignature
from eai.logic.trace import TakenAction
from eai.tasks.goal_test import StateTest
from eai.world.action import Action
from eai.world.execution import Step, Trajectory, execute_plan, to_trace
from eai.world.fault import FaultKind
from eai.world.operator import missing_step
from eai.world.state import Scene, State, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from logic.naive import Facts
from logic.random_formulas import PREDICATES, formulas, traces
from logic.random_formulas import SCENE as OBJECTS_OF_SCENE
from sweeps import examples
from threading_tests import asked_by_threads

START = flat.make_state()
SCENE = START.scene
DOMAIN = virtualhome.make_domain_with_checks_in_paper_order()
CHECK = missing_step(FALSE, "it does not hold")

Plan = tuple[str, ...]


def actions(plan: Plan) -> tuple[Action, ...]:
    return tuple(flat.parse_action(step, SCENE) for step in plan)


def do(*plans: Plan, subgoal: int, then: int, effort: int = 0) -> ExecuteSubgoalPlansInstruction:
    found = SubgoalPlanningResult([actions(plan) for plan in plans], effort)
    return ExecuteSubgoalPlansInstruction(lambda state: found, subgoal, then)


def program(subgoals: Sequence[Sequence[Plan]], effort: int = 0) -> list[Instruction]:
    """Return one instruction for each subgoal, with several plans that cost some effort."""
    made: list[Instruction] = [None]
    for number in reversed(range(len(subgoals))):
        made.append(do(*subgoals[number], subgoal=number, then=len(made) - 1, effort=effort))
    return made


def run(
    made: Sequence[Instruction], goal: str = "OPEN(fridge.10)", limits: ExplorationLimits | None = None
) -> ExplorationResult:
    progress = GoalProgress(parse(goal), SCENE)
    return explore_subgoal_program(
        DOMAIN, START, made, progress, limits or ExplorationLimits(branches=10_000)
    )


def done(outcome: ExplorationResult) -> list[str]:
    return [
        " ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)])
        for a in outcome.reported.trajectory.executed_actions
    ]


GO, OPEN, CLOSE = ("WALK fridge.10",), ("OPEN fridge.10",), ("CLOSE fridge.10",)


def test_all_plans_for_a_subgoal_are_tried() -> None:
    outcome = run(program([[("SIT fridge.10",), GO], [OPEN]]))
    assert (outcome.success, outcome.executable) == (True, True)
    assert done(outcome) == [*GO, *OPEN]


def test_a_subgoal_without_plans_is_skipped() -> None:
    assert run([None, do(subgoal=0, then=0)], "CLOSED(fridge.10)").success


def test_an_additional_step_is_noted_and_skipped() -> None:
    outcome = run(program([[GO], [OPEN], [OPEN], [CLOSE]]))
    assert outcome.success
    assert done(outcome) == [*GO, *OPEN, *CLOSE]
    assert [fault.kind for fault in outcome.reported.faults] == [FaultKind.ADDITIONAL_STEP]


def test_a_branch_ends_with_its_first_fatal_fault() -> None:
    outcome = run(program([[GO], [("GRAB milk.11",)], [OPEN]]))
    assert (outcome.success, outcome.executable) == (False, False)
    assert outcome.reported.subgoal == 1
    assert outcome.reported.failure is not None
    assert outcome.reported.failure.kind is FaultKind.MISSING_STEP


def test_a_branch_that_misses_the_goal_is_preferred_to_one_that_fails() -> None:
    outcome = run(program([[OPEN, GO]]))
    assert (outcome.success, outcome.executable) == (False, True)
    assert done(outcome) == [*GO]


def test_the_longest_failed_branch_with_fewest_errors_is_reported() -> None:
    outcome = run(program([[GO, (*GO, *OPEN), (*GO, *CLOSE, *OPEN, *CLOSE)], [("GRAB table.12",)]]))
    assert done(outcome) == [*GO, *OPEN]


def test_the_first_successful_branch_with_fewest_errors_is_reported() -> None:
    outcome = run(program([[(*GO, *CLOSE, *OPEN), (*GO, *OPEN), (*GO, *OPEN, *CLOSE)]]))
    assert done(outcome) == [*GO, *OPEN]


def test_a_required_subgoal_must_hold() -> None:
    held = flat.parse_facts(["OPEN fridge.10"], SCENE)
    (fact,) = held

    def is_open(state: State) -> bool:
        return state.has(fact.predicate, *fact.arguments)

    require = CheckSubgoalHoldsInstruction(is_open, CHECK, 2, 0)
    assert run([None, require, do((*GO, *OPEN), subgoal=0, then=1)]).success
    failed = run([None, require, do(GO, subgoal=0, then=1)])
    assert failed.reported.failure is not None
    assert (failed.reported.failure.kind, failed.reported.subgoal) == (FaultKind.MISSING_STEP, 2)
    assert [fault.kind for fault in failed.reported.faults] == [FaultKind.MISSING_STEP]
    late = run([None, require, do((*GO, *OPEN, *CLOSE), subgoal=0, then=1)])
    assert [fault.kind for fault in late.reported.faults] == [FaultKind.WRONG_ORDER]


def test_a_subgoal_takes_no_more_actions_than_it_may() -> None:
    one, two = (do(OPEN, subgoal=0, then=0), do(GO, subgoal=0, then=1))
    within = run([None, one._replace(max_actions=2), two._replace(max_actions=2)])
    assert (done(within), within.reported.executed, within.reported.refined) == ([*GO, *OPEN], 2, 1)
    beyond = run([None, one._replace(max_actions=1), two._replace(max_actions=1)])
    assert beyond.reported.failure is not None
    assert beyond.reported.failure.check.id == "too_many_actions"
    at_once = run([None, do((*GO, *OPEN), subgoal=0, then=0)._replace(max_actions=1)])
    assert (done(at_once), at_once.reported.errors) == ([], 1), "nothing of too long a plan is executed"
    apart = run([None, one._replace(subgoal=1, max_actions=1), two._replace(max_actions=1)])
    assert (apart.success, apart.reported.refined) == (True, 2)


def test_all_alternatives_are_explored() -> None:
    made = [
        None,
        do(OPEN, subgoal=1, then=0),
        do(GO, subgoal=0, then=1),
        SubgoalForkInstruction(lambda state: (1, 2), 0),
    ]
    outcome = run(made)
    assert outcome.success
    assert done(outcome) == [*GO, *OPEN]


def test_a_search_reports_the_limit_that_ended_it() -> None:
    made = program([[GO], [OPEN], [CLOSE], [OPEN]])
    outcome = run(made, limits=ExplorationLimits(attempts=2))
    assert (outcome.end, outcome.attempts, outcome.success) == ("attempts", 2, False)
    assert run(made, limits=ExplorationLimits(attempts=4)).end == "complete"
    dear = program([[GO], [OPEN], [CLOSE], [OPEN]], effort=5)
    assert run(dear, limits=ExplorationLimits(effort=15)).end == "effort"
    assert run(dear, limits=ExplorationLimits(effort=21)).end == "complete"


def test_branches_with_equal_states_are_merged() -> None:
    clean = [("WASH table.12",), ("SCRUB table.12",), ("RINSE table.12",)]
    outcome = run(program([[("WALK table.12",)], *[clean] * 40]), "CLEAN(table.12)")
    assert outcome.success
    assert outcome.attempts < 40 * 3 * 10
    assert done(outcome) == ["WALK table.12", *["WASH table.12"] * 40]


def test_branches_with_equal_states_stay_apart_if_the_trajectory_matters() -> None:
    there, back = "WALK table.12", "WALK fridge.10"
    ways = [(there,), (back,), (there, back), (back, there), (there, back, there), (back, there, back)]
    wanted = actions(ways[3])
    asked = []

    def as_wanted(course: Trajectory) -> bool:
        asked.append(course.executed_actions)
        return course.executed_actions == wanted

    progress = GoalProgress(TRUE, SCENE, trajectory_test=as_wanted)
    outcome = explore_subgoal_program(DOMAIN, START, program([ways, [()]]), progress, ExplorationLimits())
    assert outcome.success
    assert outcome.reported.trajectory.executed_actions == wanted
    assert asked == [*map(actions, ways)]


@dataclass(frozen=True)
class Reported:
    """The result of a search, in the terms of a search without merging."""

    success: bool
    executable: bool
    steps: list[str]
    kinds: list[FaultKind]


def naive(subgoals: Sequence[Sequence[Plan]], goal: str) -> Reported:
    """Search all branches breadth first, without merging."""
    progress = GoalProgress(parse(goal), SCENE)
    level: list[tuple[str, ...]] = [()]
    failed = []
    for plans in subgoals:
        after = []
        for branch in level:
            for plan in plans:
                longer = (*branch, *plan)
                trajectory = execute_plan(DOMAIN, START, actions(longer))
                (after if trajectory.failure is None else failed).append(longer)
        level = after
    runs = [execute_plan(DOMAIN, START, actions(branch)) for branch in level]
    successful, unsuccessful = [], []
    for trajectory in runs:
        met = 0
        for state, action in zip(trajectory.states, trajectory.executed_actions, strict=False):
            met = progress.count_goal_parts_met_after_action(met, state, action)
        (successful if progress.is_goal_reached_at_end(met, trajectory.final_state) else unsuccessful).append(
            trajectory
        )
    others = unsuccessful or [execute_plan(DOMAIN, START, actions(branch)) for branch in failed]
    errors = [sum(step.fault is not None for step in t.steps) for t in successful or others]
    lengths = [0 if successful else -len(t.states) for t in successful or others]
    best = (successful or others)[min(range(len(errors)), key=lambda i: (errors[i], lengths[i], i))]
    return Reported(
        bool(successful),
        bool(runs),
        [
            " ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)])
            for a in best.executed_actions
        ],
        [step.fault.kind for step in best.steps if step.fault is not None],
    )


PLANS: list[Plan] = [
    GO,
    OPEN,
    CLOSE,
    (*GO, *OPEN),
    ("WALK table.12", "WASH table.12"),
    ("WASH table.12",),
    ("SCRUB table.12",),
    ("WIPE table.12",),
    ("FIND bed.20", "SIT bed.20"),
    ("FIND bed.20", "LIE bed.20"),
    ("STANDUP",),
    ("FIND cup.13", "GRAB cup.13"),
    ("TURNTO bed.20",),
]
ENDS = (
    "CLEAN(table.12)",
    "OPEN(fridge.10) then CLOSED(fridge.10)",
    "LYING(character.65)",
    "CLEAN(table.12) and SITTING(character.65)",
    "HOLDS_RH(character.65, cup.13)",
)


@settings(deadline=None, max_examples=examples(300))
@given(
    st.lists(st.lists(st.sampled_from(PLANS), min_size=1, max_size=4), min_size=1, max_size=5),
    st.sampled_from(ENDS),
)
def test_merging_changes_nothing_that_is_reported(subgoals: list[list[Plan]], goal: str) -> None:
    outcome = run(program(subgoals), goal)
    reported = Reported(
        outcome.success, outcome.executable, done(outcome), [f.kind for f in outcome.reported.faults]
    )
    assert reported == naive(subgoals, goal)


@pytest.mark.parametrize("few", [2, 5])
def test_merging_starts_early_enough_to_be_tested(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("eai.abilities.subgoal_decomposition.search._MIN_BRANCHES_TO_MERGE", few)
    test_merging_changes_nothing_that_is_reported()


PARTS_START = flat.make_state()
PARTS_SCENE = PARTS_START.scene
SIGNATURE = FormulaSignature(
    {p.name: p.arity for p in PARTS_SCENE.vocabulary.predicates},
    {op.name: op.arity for op in virtualhome.make_domain_with_checks_in_paper_order().operators},
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
    for state, action in zip(trajectory.states, trajectory.executed_actions, strict=False):
        met = progress.count_goal_parts_met_after_action(met, state, action)
    assert progress.is_goal_reached_at_end(met, trajectory.final_state) == semantics.holds(
        formula, to_trace(trajectory)
    )


@settings(deadline=None)
@given(GOALS, st.lists(st.sampled_from(STEPS), max_size=8))
def test_progress_agrees_with_the_semantics_of_formulas(goal: str, steps: list[str]) -> None:
    plan = [flat.parse_action(step, PARTS_SCENE) for step in steps]
    trajectory = execute_plan(virtualhome.make_domain_with_checks_in_paper_order(), PARTS_START, plan)
    assert_progress_agrees(read_formula(goal, SIGNATURE)[0], trajectory)


def in_scene(formula: Formula, scene: Scene) -> Formula:
    """Return a random formula about existing objects, without comparisons of an action's objects."""

    def known(leaf: Leaf, bound: frozenset[str]) -> Formula:
        if isinstance(leaf, Equals):
            return Equals(*(of_scene(term) for term in (leaf.left, leaf.right)))
        return replace(leaf, arguments=tuple([of_scene(term) for term in leaf.arguments]))

    def of_scene(term: Term) -> Term:
        is_known = isinstance(term, Variable) or term.name in scene.index
        return term if is_known else Constant(scene.objects[len(term.name) % len(scene.objects)].name)

    return rewrite_leaves(formula, known)


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
        tuple(Step(Action(name, indices(arguments)), None) for name, arguments in actions),
    )
    made = [in_scene(part, scene) for part in parts]
    assert_progress_agrees(made[0] if len(made) == 1 else Then(tuple(made)), trajectory)


@pytest.mark.parametrize("objects", ["abc", "aba", "ab", "axc", "xxy"])
def test_progress_agrees_on_actions_with_three_objects(objects: str) -> None:
    scene = Scene(Vocabulary((Predicate("held", 1),)), [WorldObject(name, "thing") for name in "abc"])
    state = scene.state([("held", (0,))])
    x, y = Variable("x"), Variable("y")
    terms = [{"x": x, "y": y}.get(name, Constant(name)) for name in objects]
    goal = Exists(x, Exists(y, And((Atom("held", (Constant("a"),)), Occurs("carry", tuple(terms))))))
    for arguments in product(range(3), repeat=3):
        carried = Step(Action("carry", arguments), None)
        assert_progress_agrees(goal, Trajectory((state, state), (carried,)))


def test_one_position_meets_at_most_one_part() -> None:
    progress = GoalProgress(parse("CLOSED(fridge.10) then CLOSED(fridge.10)"), PARTS_SCENE)
    assert not progress.is_goal_reached_at_end(0, PARTS_START)
    assert progress.is_goal_reached_at_end(
        progress.count_goal_parts_met_after_action(0, PARTS_START, Action("STANDUP", ())), PARTS_START
    )


def test_goals_at_the_end_are_tested_in_the_last_state() -> None:
    is_open = StateTest(parse("OPEN(fridge.10)"), PARTS_SCENE)
    progress = GoalProgress(parse("CLOSED(fridge.10)"), PARTS_SCENE, is_open)
    assert not progress.is_goal_reached_at_end(0, PARTS_START)
    assert progress.is_goal_reached_at_end(1, flat.make_state("OPEN fridge.10", over=PARTS_SCENE))
    assert not progress.is_goal_reached_at_end(1, PARTS_START)


def test_a_goal_is_a_sequence_of_state_formulas() -> None:
    with pytest.raises(InputError, match="sequence of state formulas"):
        GoalProgress(parse("(p(a) then q(a)) and r(a)"), PARTS_SCENE)


def test_a_formula_is_tested_on_one_state() -> None:
    test = StateTest(parse("exists x. (ONTOP(cup.13, x) and DIRTY(x))"), PARTS_SCENE)
    assert test(PARTS_START)
    assert not test(flat.make_state("-DIRTY table.12", over=PARTS_SCENE))


def test_several_threads_may_use_one_goal_test() -> None:
    on = "exists y. (exists z. (ONTOP(x, y) and y = z))"
    test = StateTest(parse(f"forall x. (({on}) or not ({on}))"), PARTS_SCENE)
    assert asked_by_threads(lambda i: test(PARTS_START), 1_000)
