from __future__ import annotations

import pytest

from abilities.subgoal_decomposition.test_scorer import TASK
from eai.abilities.subgoal_decomposition.program import SubgoalPlanningResult
from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
from eai.logic.formula import And, Atom, Constant, Formula, Not
from eai.planning.subgoal import GroundAtom
from eai.tasks.goal_test import StateTest
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.effect import Add, Delete
from eai.world.frame import AGENT
from eai.world.operator import Operator, OperatorRole, additional_step, missing_step
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy

SCENE = TASK.scene
REFINEMENT = SubgoalRefiner(toy.DOMAIN)


def literal(text: str) -> GroundAtom:
    """Return a literal written as ``not at red shed``."""
    words = text.removeprefix("not ").split()
    return GroundAtom(words[0], tuple([SCENE.index[name] for name in words[1:]]), not text.startswith("not "))


def formula(each: GroundAtom) -> Formula:
    atom = Atom(each.predicate, tuple([Constant(SCENE.objects[i].name) for i in each.arguments]))
    return atom if each.truth else Not(atom)


def plans(*literals: str, refinement: SubgoalRefiner = REFINEMENT) -> list[str]:
    """Return the plans for a conjunction in the initial state."""
    wanted = [literal(text) for text in literals]
    holds = StateTest(And(tuple(map(formula, wanted))), SCENE)
    return written(refinement.make_planner_for_literals(wanted, holds, SCENE, TASK.relevant)(TASK.initial))


def written(found: SubgoalPlanningResult) -> list[str]:
    return ["too far"] * (found.failed_check is not None) + [
        ", ".join(" ".join([a.operator, *(SCENE.objects[i].name for i in a.arguments)]) for a in plan)
        for plan in found.plans
    ]


@pytest.mark.parametrize(
    ("literals", "expected"),
    [
        (["lit lamp"], ["GO shed, PRESS lamp"]),
        (["at robot shed"], ["GO shed"]),
        (["at red shed"], ["LIFT red, GO shed"]),
        (["beside lamp"], ["GO shed"]),
        # One change for each literal; taking and moving do not count as changes.
        (["holding blue", "at robot shed"], ["GO shed, LIFT blue"]),
        # More actions than allowed.
        (["holding red", "lit lamp"], ["too far"]),
        (["at blue hall", "lit lamp"], ["too far"]),
        # An impossible subgoal ends in the attempt that fails.
        (["lit red"], ["PRESS red"]),
        (["holding red", "holding blue"], ["LIFT red, GO shed, LIFT blue"]),
        # Each part can be reached, but not both together: no action fails.
        (["at robot hall", "at robot shed"], [""]),
    ],
)
def test_the_shortest_plan_is_found(literals: list[str], expected: list[str]) -> None:
    assert plans(*literals) == expected


def test_all_shortest_plans_are_found() -> None:
    here = toy.at(AGENT, toy.X)
    elsewhere = "the robot is elsewhere"
    ring = Operator("RING", (toy.X,), (missing_step(here, elsewhere),), (Add(toy.lit(toy.X)),))
    shout = Operator("SHOUT", (toy.X,), (missing_step(here, elsewhere),), (Add(toy.lit(toy.X)),))
    domain = toy.DOMAIN.replace_operators(ring, shout)
    assert plans("lit hall", refinement=SubgoalRefiner(domain)) == ["RING hall"], "they lead to one state"
    wanted = literal("lit hall")
    distinguished = SubgoalRefiner(domain).make_planner_for_literals(
        [wanted], StateTest(formula(wanted), SCENE), SCENE, TASK.relevant, {"RING", "SHOUT"}
    )
    assert written(distinguished(TASK.initial)) == ["RING hall", "SHOUT hall"]


def test_a_subgoal_may_say_more_than_its_literals() -> None:
    lit, away = literal("lit lamp"), literal("not at robot shed")
    holds = StateTest(And((formula(lit), formula(away))), SCENE)
    found = REFINEMENT.make_planner_for_literals([lit], holds, SCENE, TASK.relevant)(TASK.initial)
    assert found.has_failed, "the lamp is lit in the shed alone"


@pytest.mark.parametrize(
    ("action", "expected"),
    [
        ("PRESS lamp", ["GO shed, PRESS lamp"]),
        ("LIFT red", ["LIFT red"]),
        ("DROP blue", ["DROP blue"]),  # an object is not taken only to release it
        ("GO hall", ["GO hall"]),  # the agent is there already: it does not leave and come back
    ],
)
def test_an_action_follows_the_actions_that_enable_it(action: str, expected: list[str]) -> None:
    operator, *names = action.split()
    ground = Action(operator, tuple([SCENE.index[name] for name in names]))
    assert (
        written(REFINEMENT.make_planner_for_action_subgoal(ground, SCENE, TASK.relevant)(TASK.initial))
        == expected
    )


def test_a_literal_that_no_action_changes_has_no_plan() -> None:
    fixed = Predicate("fixed", 1, static=True)
    vocabulary = Vocabulary((*toy.VOCABULARY.predicates, fixed), toy.VOCABULARY.derived)
    refinement = SubgoalRefiner(Domain("toy", vocabulary, (toy.GO, toy.PRESS)))
    for name, expected in (("fixed", False), ("holding", False), ("lit", True), ("beside", True)):
        assert refinement.can_bring_about(GroundAtom(name, (0,), True)) is expected


LATCH = Operator(
    "LATCH", (toy.X,), (missing_step(toy.holding(toy.X), "{x} is not held"),), (Add(toy.lit(toy.X)),)
)
BLESS = Operator(
    "BLESS",
    (toy.X,),
    (missing_step(toy.at(toy.X, toy.X), "never"), missing_step(toy.holding(toy.X), "{x} is not held")),
    (Add(toy.lit(toy.X)),),
)


@pytest.mark.parametrize(
    ("operators", "literals", "attempt"),
    [
        # Movement precedes the attempt if it makes fewer checks fail.
        ((), ["lit red"], "PRESS red"),
        ((), ["lit blue"], "GO shed, PRESS blue"),
        ((), ["holding lamp"], "GO shed, LIFT lamp"),
        ((), ["lit hall"], "PRESS hall"),
        ((), ["at robot red"], "GO red"),
        # The possible actions come first.
        ((), ["lit lamp", "lit red"], "GO shed, PRESS lamp, GO hall, PRESS red"),
        ((), ["holding red", "holding blue"], "LIFT red, GO shed, LIFT blue"),
        # Of two useful actions the one with fewer failing checks is reported.
        ((BLESS,), ["lit red"], "PRESS red"),
        # If the action that would establish the check fails as well, it is reported.
        ((LATCH,), ["lit hall"], "LIFT hall"),
        # No action fails: they run one after the other.
        ((LATCH,), ["lit red"], "LIFT red, LATCH red"),
        (
            (LATCH,),
            ["lit blue", "lit red"],
            "LIFT red, LATCH red, LIFT blue",
        ),
    ],
)
def test_without_a_plan_the_attempt_with_fewest_failures_is_reported(
    operators: tuple[Operator, ...], literals: list[str], attempt: str
) -> None:
    refinement = SubgoalRefiner(toy.DOMAIN.replace_operators(*operators))
    assert plans(*literals, refinement=refinement) == [attempt]


def test_the_reported_attempt_is_the_direct_one() -> None:
    """Dropping the object meets half of the subgoal, but the object must be stowed."""
    checks = (
        missing_step(toy.holding(toy.X), "{x} is not held"),
        missing_step(toy.at(toy.X, toy.X), "it is shut"),
    )
    stow = Operator("STOW", (toy.X,), checks, (Add(toy.lit(toy.X)), Delete(toy.holding(toy.X))))
    refinement = SubgoalRefiner(toy.DOMAIN.replace_operators(stow))
    wanted = [literal("lit red"), literal("not holding red")]
    holds = StateTest(And(tuple(map(formula, wanted))), SCENE)
    lift = toy.DOMAIN.compiled_operators["LIFT"]
    held = lift.apply(TASK.initial, lift.bind(TASK.initial, (SCENE.index["red"],)))
    found = refinement.make_planner_for_literals(wanted, holds, SCENE, TASK.relevant)(held)
    assert written(found) == ["STOW red"]


LAY = Operator(
    "LAY",
    (toy.X,),
    (additional_step(toy.holding(toy.X), "{x} is not held"),),
    (Delete(toy.holding(toy.X)),),
    role=OperatorRole.RELEASES,
)
STEP = Operator("STEP", toy.GO.parameters, toy.GO.checks, toy.GO.effects)
DIM = Operator("DIM", (toy.X,), (additional_step(toy.lit(toy.X), "it is dark"),), (Delete(toy.lit(toy.X)),))


@pytest.mark.parametrize(
    ("literals", "needless"),
    [
        (["at robot hall"], "GO hall"),  # one action is reported, although STEP is not needed either
        (["not lit lamp"], "DIM lamp"),
        (["at robot hall", "not lit lamp"], "GO hall, DIM lamp"),
        (["not lit lamp", "at robot hall"], "DIM lamp, GO hall"),
        (["not holding red"], ""),  # an object that is not held need not be laid down
        (["not holding red", "at robot hall"], "GO hall"),
        (["at robot hall", "lit lamp"], None),
    ],
)
def test_needless_actions_are_listed_for_literals_that_hold(
    literals: list[str], needless: str | None
) -> None:
    refinement = SubgoalRefiner(toy.DOMAIN.replace_operators(LAY, STEP, DIM))
    found = refinement.find_needless_actions_for_true_literals(
        [literal(text) for text in literals], TASK.initial
    )
    assert (None if found is None else written(SubgoalPlanningResult([found]))) == (
        None if needless is None else [needless]
    )


def test_a_search_reports_its_effort() -> None:
    in_vain = REFINEMENT.make_planner_for_literals(
        [literal("lit lamp")], lambda _: False, SCENE, TASK.relevant
    )
    assert 0 < in_vain(TASK.initial).effort <= 3 * 300, "three searches at most, each within its budget"
    efforts = [
        REFINEMENT.make_planner_for_literals(
            [literal("lit lamp")] * changes, lambda _: False, SCENE, TASK.relevant
        )(TASK.initial).effort
        for changes in (1, 99, 100, 199, 200)
    ]
    assert efforts == sorted(efforts), "more literals are not tested in less time"


def test_plans_longer_than_a_known_plan_are_not_searched() -> None:
    nod = Operator("NOD", (toy.X,), (), (Add(toy.at(toy.X, AGENT)),), role=OperatorRole.MOVEMENT)
    refinement = SubgoalRefiner(toy.DOMAIN.replace_operators(nod))
    there = refinement.make_planner_for_literals(
        [literal("at robot shed")], lambda _: True, SCENE, TASK.relevant
    )
    found = there(TASK.initial)
    assert written(found) == ["GO shed"]
    assert found.effort == 3, "GO, NOD, and the first of what is longer; not GO after NOD"


def test_a_search_stops_at_its_limit() -> None:
    few = SubgoalRefiner(toy.DOMAIN, budget=1)
    assert plans("holding red", "at robot shed", refinement=few) != plans("holding red", "at robot shed")
