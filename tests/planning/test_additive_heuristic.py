from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, permutations
from random import Random

import pytest

from eai.logic.formula import And, Atom, Constant, Exactly, Exists, Formula, ForPairs, Not, Or, Variable
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, CostEstimates
from eai.planning.greedy_search import _PreferredActionCollector
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits, SearchEffort, SearchNode
from eai.planning.subgoal import GroundAtom, Subgoal
from eai.planning.successor_generator import SuccessorGenerator
from eai.world import Add, ForEach, Operator
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.operator import affordance, missing_step
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy
from world.toy import X, Y, at, holding

START = toy.initial()
SCENE = START.scene
EVERYTHING = tuple(range(len(SCENE.objects)))
HEURISTIC = AdditiveHeuristic(toy.DOMAIN)


def named(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def subgoal(formula: Formula) -> Subgoal:
    return Subgoal(formula, {}, True)


LAMP_LIT = named("lit", "lamp")
RED_IN_SHED = named("at", "red", "shed")
BOX = Variable("x", "box")
PLACE = Variable("y", "place")


@pytest.mark.parametrize(
    ("condition", "cost"),
    [
        (named("at", "red", "hall"), 0),
        (named("holding", "red"), 1),
        (named("holding", "blue"), 2),  # GO, LIFT
        (LAMP_LIT, 2),  # GO, PRESS
        (RED_IN_SHED, 2),  # LIFT, GO
        (Not(named("at", "robot", "hall")), 1),
        (And((LAMP_LIT, named("holding", "red"))), 3),
        (Or((LAMP_LIT, named("holding", "red"))), 1),
        (Exists(X, holding(X)), 1),
        (named("at", "lamp", "hall"), INFINITE),
    ],
)
def test_the_estimate_adds_up_the_needed_actions(condition: Formula, cost: float) -> None:
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    assert estimates.estimate(Subgoal(condition, {}, True)) == cost


def test_conditions_on_other_objects_of_an_operator_are_established() -> None:
    show = Operator("SHOW", (Y,), (), (ForEach(X, at(X, Y) & toy.holding(X), (Add(toy.lit(X)),)),))
    domain = replace(toy.DOMAIN, operators=(toy.GO, toy.LIFT, show))
    estimates = CostEstimates(AdditiveHeuristic(domain), START, EVERYTHING)
    assert estimates.estimate(subgoal(named("lit", "red"))) == 2, "LIFT, SHOW"
    assert estimates.estimate(subgoal(named("lit", "lamp"))) == INFINITE, "it cannot be lifted"


def preferred(estimates: CostEstimates, formula: Formula) -> list[Action]:
    found = _PreferredActionCollector(HEURISTIC, estimates)
    found.collect_actions_towards(Subgoal(formula, {}, True))
    return list(found.actions)


def test_preferred_actions_are_possible_at_once() -> None:
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    go, lift = Action("GO", (SCENE.index["shed"],)), Action("LIFT", (SCENE.index["red"],))
    both = And((LAMP_LIT, named("holding", "red")))
    assert preferred(estimates, LAMP_LIT) == [go]
    assert preferred(estimates, both) == [go, lift]
    supporter = estimates.find_cheapest_action_of_operators(("PRESS",))
    assert (supporter.cost, supporter.action) == (2.0, Action("PRESS", (SCENE.index["lamp"],)))
    found = _PreferredActionCollector(HEURISTIC, estimates)
    found.collect_action_or_actions_for_prerequisites(supporter.action, supporter.prerequisites)
    assert list(found.actions) == [go]
    assert estimates.find_cheapest_action_of_operators(("FLY",)).cost == INFINITE


def test_an_action_that_undoes_a_protected_condition_costs_more() -> None:
    something_in_hall = Exists(X, at(X, Constant("hall")))
    robot_in_hall = named("at", "robot", "hall")
    away = subgoal(named("at", "robot", "shed"))
    assert CostEstimates(HEURISTIC, START, EVERYTHING, [subgoal(robot_in_hall)]).estimate(away) == 2
    assert CostEstimates(HEURISTIC, START, EVERYTHING, [subgoal(something_in_hall)]).estimate(away) == 1
    for protected, cost in ((robot_in_hall, INFINITE), (something_in_hall, 1)):
        estimates = CostEstimates(
            HEURISTIC, START, EVERYTHING, [subgoal(protected)], forbid_undoing_protected=True
        )
        assert estimates.estimate(away) == cost


def test_an_estimate_is_infinite_at_its_maximum() -> None:
    lit = subgoal(named("lit", "lamp"))
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    assert estimates.estimate(lit, 2.0) == INFINITE
    assert estimates.estimate(lit, 3.0) == 2.0


def test_a_condition_is_reduced_to_its_cheapest_parts() -> None:
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    lifted = named("holding", "red")
    both = And((Or((LAMP_LIT, lifted)), Not(named("lit", "lamp"))))
    assert [part.formula for part in estimates.split_into_cheapest_literal_subgoals(subgoal(both))] == [
        lifted,
        LAMP_LIT,
    ]
    assert estimates.split_into_cheapest_literal_subgoals(subgoal(LAMP_LIT)) == (subgoal(LAMP_LIT),)
    assert estimates.find_cheapest_disjuncts(subgoal(Or((LAMP_LIT, lifted)))) == [subgoal(lifted)]


def test_counted_and_paired_conditions_are_chosen_by_cost() -> None:
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    boxes = [SCENE.index[name] for name in ("red", "blue")]
    one = estimates.split_into_cheapest_literal_subgoals(subgoal(Exactly(1, BOX, holding(X))))
    assert [(each.scope["x"], each.truth) for each in one] == [(boxes[0], True), (boxes[1], False)]
    pairs = estimates.split_into_cheapest_literal_subgoals(subgoal(ForPairs(BOX, PLACE, at(X, Y))))
    places = [SCENE.index[name] for name in ("hall", "shed")]
    assert [(each.scope["x"], each.scope["y"]) for each in pairs] == list(zip(boxes, places, strict=True))


@pytest.mark.parametrize("count", [3, 999_999_999])
def test_counting_more_objects_than_exist_is_unreachable(count: int) -> None:
    estimates = CostEstimates(HEURISTIC, START, EVERYTHING)
    for goal in (Exactly(count, BOX, holding(X)), ForPairs(BOX, PLACE, at(X, Y), count)):
        assert estimates.estimate(subgoal(goal)) == INFINITE


def test_pairs_are_found_where_the_cheapest_pair_belongs_to_no_choice() -> None:
    """The ball is already in the hall, but only there is room for the box."""
    at_place, fits = Predicate("at", 2), Predicate("fits", 2, static=True)
    thing, place = Variable("x", "thing"), Variable("y", "place")
    checks = (affordance(fits(thing, place), "{x} does not fit into {y}"),)
    domain = Domain(
        "rooms",
        Vocabulary((at_place, fits)),
        (Operator("MOVE", (thing, place), checks, (Add(at_place(thing, place)),)),),
    )
    scene = Scene(domain.vocabulary, {"box": "thing", "ball": "thing", "hall": "place", "shed": "place"})
    ball_in_hall = Fact("at", (1, 2))
    state = scene.state([ball_in_hall, *(Fact("fits", pair) for pair in ((0, 2), (1, 2), (1, 3)))])
    goal = ForPairs(thing, place, at_place(thing, place))
    assert CostEstimates(AdditiveHeuristic(domain), state, range(4)).estimate(subgoal(goal)) == 2
    assert len(Planner(domain).find_plan(state, PlanningGoal([goal]), range(4)).plan) == 2


def chain(length: int) -> tuple[Domain, State, Formula]:
    """Return a domain in which each thing is made from the one before, with the last thing as the goal."""
    made, following = Predicate("made", 1), Predicate("following", 2, static=True)
    a, b = Variable("a"), Variable("b")
    checks = (affordance(following(a, b), "{b} does not follow"), missing_step(made(a), "{a} is not made"))
    make = Operator("MAKE", (a, b), checks, (Add(made(b)),))
    domain = Domain("chain", Vocabulary((made, following)), (make,))
    scene = Scene(domain.vocabulary, {f"t{i}": "thing" for i in range(length + 1)})
    order = [Fact("following", (i, i + 1)) for i in range(length)]
    return domain, scene.state([Fact("made", (0,)), *order]), made(Constant(f"t{length}"))


def test_a_condition_behind_a_long_chain_looks_unreachable() -> None:
    """300 nested estimates would exceed Python's recursion limit."""
    for length, near in ((40, True), (300, False)):
        domain, state, goal = chain(length)
        assert Planner(domain).looks_reachable(state, goal, range(length + 1)) is near


def test_a_condition_that_looks_unreachable_is_found_by_a_thorough_search() -> None:
    domain, state, goal = chain(70)
    assert len(Planner(domain).find_plan(state, PlanningGoal((goal,)), range(71)).plan) == 70


@pytest.mark.parametrize("seed", range(5))
def test_estimates_on_a_random_walk_are_equal_to_estimates_without_caches(seed: int) -> None:
    goals = [LAMP_LIT, RED_IN_SHED, And((LAMP_LIT, named("holding", "blue"))), Exists(X, holding(X))]
    choice, state, looks = Random(seed), START, SearchEffort()
    previous = None
    for _ in range(12):
        fresh = AdditiveHeuristic(toy.DOMAIN)
        for protected in ((), (subgoal(RED_IN_SHED),)):
            kept = CostEstimates(HEURISTIC, state, EVERYTHING, protected, looks, previous=previous)
            previous = kept
            new = CostEstimates(fresh, state, EVERYTHING, protected)
            for goal in goals:
                assert kept.estimate(subgoal(goal)) == new.estimate(subgoal(goal))
                assert preferred(kept, goal) == preferred(new, goal)
            assert kept.find_cheapest_action_of_operators(
                ("PRESS",)
            ) == new.find_cheapest_action_of_operators(("PRESS",))
        successors = SuccessorGenerator(toy.DOMAIN, EVERYTHING)
        action = choice.choice(list(successors.generate_applicable_actions(SearchNode(state))))
        state = toy.DOMAIN.apply(state, action)


def test_conditions_that_help_to_establish_each_other_look_reachable() -> None:
    """Of three things in a row, each is made from the two others."""
    made, recipe = Predicate("made", 1), Predicate("recipe", 3, static=True)
    a, b, c = map(Variable, "abc")
    needed = [missing_step(made(part), "a part is not made") for part in (a, b)]
    checks = (affordance(recipe(a, b, c), "there is no recipe"), *needed)
    domain = Domain(
        "recipes", Vocabulary((made, recipe)), (Operator("MAKE", (a, b, c), checks, (Add(made(c)),)),)
    )
    scene = Scene(domain.vocabulary, {f"t{i}": "thing" for i in range(20)})
    recipes = [Fact("recipe", three) for i in range(18) for three in permutations((i, i + 1, i + 2))]
    state = scene.state([Fact("made", (0,)), Fact("made", (1,)), *recipes])
    for i in range(20):
        assert Planner(domain).looks_reachable(state, made(Constant(f"t{i}")), range(20))


def test_a_counted_condition_that_needs_its_own_result_is_estimated_again() -> None:
    """A lamp needs power. Power comes from a generator that is built in three steps, or from a lit lamp."""
    lit, power, built = Predicate("lit", 1), Predicate("power", 0), Predicate("built", 1)
    bulb, parts = Variable("bulb", "lamp"), [built(Constant(name)) for name in "abc"]
    operators = [
        Operator("SWITCH", (X,), (missing_step(power(), "no power"),), (Add(lit(X)),)),
        Operator("BORROW", (), (missing_step(Exactly(1, bulb, lit(bulb)), "no light"),), (Add(power()),)),
        Operator("START", (), (missing_step(parts[-1], "not built"),), (Add(power()),)),
        Operator("BEGIN", (), (), (Add(parts[0]),)),
        *[
            Operator(f"BUILD{i}", (), (missing_step(before, "too early"),), (Add(after),))
            for i, (before, after) in enumerate(pairwise(parts))
        ],
    ]
    domain = Domain("lamps", Vocabulary((lit, power, built)), tuple(operators))
    scene = Scene(domain.vocabulary, {"lamp": "lamp", "a": "part", "b": "part", "c": "part"})
    estimates = CostEstimates(AdditiveHeuristic(domain), scene.state([]), range(4))
    assert estimates.estimate(subgoal(power())) == 4
    assert estimates.estimate(subgoal(lit(Constant("lamp")))) == 5


def test_an_action_is_tested_once_in_a_state() -> None:
    (domain, state, goal), looks = chain(6), SearchEffort()
    estimates = CostEstimates(AdditiveHeuristic(domain), state, range(7), looks=looks)
    assert estimates.estimate(subgoal(goal)) == 6
    assert looks.used == 6


def test_an_action_is_tested_again_only_if_a_fact_that_it_needs_changed() -> None:
    (domain, state, goal), looks = chain(6), SearchEffort()
    heuristic = AdditiveHeuristic(domain)
    first = CostEstimates(heuristic, state, range(7), looks=looks)
    assert first.estimate(subgoal(goal)) == 6
    action = next(SuccessorGenerator(domain, range(7)).generate_applicable_actions(SearchNode(state)))
    second = CostEstimates(heuristic, domain.apply(state, action), range(7), looks=looks, previous=first)
    assert second.estimate(subgoal(goal)) == 5
    assert looks.used == 7


def test_earlier_estimates_stay_estimates_from_their_own_state() -> None:
    lit, in_shed = subgoal(LAMP_LIT), subgoal(RED_IN_SHED)
    first = CostEstimates(HEURISTIC, START, EVERYTHING)
    costs = [CostEstimates(HEURISTIC, START, EVERYTHING).estimate(goal) for goal in (lit, in_shed)]
    assert first.estimate(lit) == costs[0]
    for action in SuccessorGenerator(toy.DOMAIN, EVERYTHING).generate_applicable_actions(SearchNode(START)):
        after = toy.DOMAIN.apply(START, action)
        CostEstimates(HEURISTIC, after, EVERYTHING, previous=first).estimate(in_shed)
    assert first.estimate(in_shed) == costs[1]


def test_a_condition_that_costs_too_much_saves_the_estimates_of_others() -> None:
    """FINISH needs any ready thing and the end of a chain. PREPARE is tested for one thing, not for seven."""
    chained, _, end = chain(6)
    ready, done, a = Predicate("ready", 1), Predicate("done", 0), Variable("a")
    checks = (missing_step(ready(a), "{a} is not ready"), missing_step(end, "the end is not made"))
    finish = Operator("FINISH", (a,), checks, (Add(done()),))
    prepare = Operator("PREPARE", (a,), (), (Add(ready(a)),))
    vocabulary = Vocabulary((*chained.vocabulary.predicates, ready, done))
    domain = Domain("finish", vocabulary, (*chained.operators, finish, prepare))
    scene = Scene(vocabulary, {f"t{i}": "thing" for i in range(7)})
    state = scene.state([Fact("made", (0,)), *[Fact("following", (i, i + 1)) for i in range(6)]])
    looks = SearchEffort()
    estimates = CostEstimates(AdditiveHeuristic(domain), state, range(7), looks=looks)
    assert estimates.estimate(subgoal(done()), 6.0) == INFINITE
    assert looks.used == 7 + 1 + 3, "FINISH for each thing, PREPARE for one, MAKE for the last three"


def reachable(domain: Domain, start: State) -> list[tuple[int, ...]]:
    """Return the arguments of the actions on seven things that may become possible after a state."""
    finder = AdditiveHeuristic(domain).achievers.get_atom_achiever_finder(start, 0b1111111)
    atoms = [GroundAtom("made", (i,), True) for i in range(7)]
    matches = [match for atom in atoms for match in finder.find_achievers_of_atom(atom)]
    actions = finder.make_reachable_action_finder(start)
    return [
        found.action.arguments for match in matches for found in actions.find_reachable_actions(match) or ()
    ]


def test_actions_that_never_become_possible_are_left_out() -> None:
    domain, first, _ = chain(6)
    later = first.replace_all_facts([Fact("made", (3,)), *list(first.facts())[1:]])
    pairs = [(i, i + 1) for i in range(6)]
    assert reachable(domain, first) == pairs
    assert reachable(domain, later) == pairs[3:]
    b = Variable("b")
    hidden = Operator("HIDE", (b,), (), (ForEach(b, Atom("made", (b,)), (Add(Atom("made", (b,))),)),))
    assert reachable(domain.replace_operators(hidden), later) == pairs, "its effect has no schema"


def test_each_search_finds_its_own_reachable_actions() -> None:
    domain, first, _ = chain(6)
    later = first.replace_all_facts([Fact("made", (3,)), *list(first.facts())[1:]])
    planner, goal = Planner(domain), PlanningGoal((named("made", "t2"),))
    limits = Limits(thorough=False)
    plans = [planner.find_plan(state, goal, range(7), limits).plan for state in (later, first, later)]
    assert list(map(len, plans)) == [0, 2, 0]
