from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from eai.logic.formula import (
    FALSE,
    TRUE,
    Atom,
    Constant,
    Equals,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Occurs,
    Variable,
)
from eai.pddl.check import check_domain, check_problem
from eai.pddl.execute import PddlPlanExecutor, PlanStep
from eai.pddl.export import ExportedProblem, ProblemToExport, export_domain_and_problem, export_problems
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import search
from eai.pddl.writer import write_domain, write_effect, write_formula, write_problem
from eai.planning.search import Limits, SearchEndReason
from eai.world.action import Action, Fault
from eai.world.derived import ComputedPredicate, DefinedPredicate, is_a
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.execution import attempt_action
from eai.world.frame import AGENT
from eai.world.history import History
from eai.world.operator import Operator, OperatorAlternative, additional_step, affordance, missing_step
from eai.world.relation import iterate_bits
from eai.world.state import Fact, Scene, State, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary

X, Y, Z = Variable("x"), Variable("y"), Variable("z")
RED = Predicate("RED", 1)
BIG = Predicate("big", 1)
LIT = Predicate("lit", 0)
ON = Predicate("ON", 2)
NEAR = Predicate("near by", 2)
MEMORY = Predicate("memory", 1, visible=False)


def _below(state: State, arguments: tuple[int, ...]) -> int:
    """Return all objects below an object, along any chain."""
    found, new = 0, state.relation("ON").row(arguments[0])
    while new & ~found:
        found |= new
        for thing in iterate_bits(found):
            new |= state.relation("ON").row(thing)
    return found


ABOVE = DefinedPredicate("above", (X, Y), ON(X, Y) | Exists(Z, ON(X, Z) & Atom("above", (Z, Y))), _below)
CLEAR = DefinedPredicate("clear", (X,), ~Exists(Y, ON(Y, X)))
RECALLED = DefinedPredicate("recalled", (X,), MEMORY(X) & RED(X))
ODD = ComputedPredicate("odd", 1, lambda state, arguments: arguments[0] % 2 == 1, ())
VOCABULARY = Vocabulary((RED, BIG, LIT, ON, NEAR, MEMORY), (ABOVE, CLEAR, RECALLED, ODD))
SCENE = Scene(
    VOCABULARY,
    [
        WorldObject(name, kind)
        for name, kind in (("me", "person"), ("A.1", "cup"), ("a_1", "cup"), ("b", "box"))
    ],
    agent=0,
)


def domain(*operators: Operator) -> Domain:
    return Domain("toy", VOCABULARY, operators)


def test_engine_and_exported_operators_reach_the_same_states_whatever_the_effects() -> None:
    """Random operators, with all kinds of effects in any order, tried with all arguments in random states."""
    rng = random.Random(7)
    compared = changed = 0
    for _ in range(150):
        operator = Operator("act", (X,), (), tuple(_effects(rng, 2, [X])))
        toy = domain(operator)
        for _ in range(3):
            initial = _state(rng)
            exported = export_domain_and_problem(toy, initial, ())
            executor = PddlPlanExecutor(exported.domain, exported.problem)
            assert exported.export_state(initial) <= executor.initial_state
            static = executor.initial_state - exported.export_state(initial)
            for thing in range(len(SCENE.objects)):
                action = Action("act", (thing,))
                after = attempt_action(toy, History(initial), action)
                assert isinstance(after, State)
                assert (
                    executor.execute_step(executor.initial_state, exported.to_pddl_step(action))
                    == exported.export_state(after) | static
                )
                compared += 1
                changed += after != initial
    assert compared == 1800
    assert changed > 900


def _state(rng: random.Random) -> State:
    things = range(len(SCENE.objects))
    facts = [(p.name, (i,)) for p in (RED, BIG, MEMORY) for i in things if rng.random() < 0.4]
    pairs = [(p.name, (i, j)) for p in (ON, NEAR) for i in things for j in things if rng.random() < 0.3]
    return SCENE.state([*facts, *pairs, *([(LIT.name, ())] if rng.random() < 0.5 else [])])


def _effects(rng: random.Random, depth: int, terms: list[Variable]) -> Iterator[Effect]:
    for _ in range(rng.randint(1, 3)):
        kind = rng.choice(("write", "write", "write", "when", "each", "let")) if depth else "write"
        new = Variable(f"v{depth}")
        inside = tuple(_effects(rng, depth - 1, [*terms, new])) if kind in ("each", "let") else ()
        match kind:
            case "when":
                then, otherwise = (tuple(_effects(rng, depth - 1, terms)) for _ in range(2))
                yield When(_condition(rng, terms), then, otherwise)
            case "each":
                yield ForEach(new, _condition(rng, [*terms, new]), inside)
            case "let":
                yield Let(new, _condition(rng, [*terms, new]), inside)
            case _:
                yield _write(rng, terms)


def _write(rng: random.Random, terms: list[Variable]) -> Effect:
    predicate = rng.choice((RED, ON, ON, LIT))
    effect = rng.choice((Add, Delete))
    chosen = [rng.choice([*terms, AGENT]) for _ in range(predicate.arity)]
    if effect is Delete and chosen and rng.random() < 0.4:
        chosen[rng.randrange(len(chosen))] = ANYTHING
    return effect(predicate(*chosen))


def _condition(rng: random.Random, terms: list[Variable]) -> Formula:
    a, b = rng.choice(terms), rng.choice(terms)
    return rng.choice(
        (
            RED(a),
            ~BIG(a),
            ON(a, b),
            NEAR(a, AGENT),
            ABOVE(a, b),
            CLEAR(a) & ~Equals(a, b),
            Exists(Y, ON(Y, a) & RED(Y)),
            ForAll(Y, ON(Y, a) | LIT()),
            is_a(a, "cup", "box"),
        )
    )


CHECKED = Operator(
    "Check It",
    (X,),
    (affordance(BIG(X), "small"), additional_step(~RED(X), "red"), missing_step(CLEAR(X), "covered")),
    (Add(RED(X)),),
)


def test_checks_are_preconditions_and_names_are_pddls() -> None:
    initial = SCENE.state([("big", (1,))])
    exported = export_domain_and_problem(domain(CHECKED), initial, (RED(Constant("A.1")),))
    (action,) = exported.domain.actions
    assert action.name == "check_it"
    assert write_formula(action.precondition) == "(and (big ?x) (not (red ?x)) (clear ?x))"
    assert write_formula(exported.problem.goal) == "(red a_1)"
    assert exported.to_pddl_step(Action("Check It", (2,))) == PlanStep("check_it", ("a_1-2",))
    assert exported.to_action(PlanStep("check_it", ("a_1-2",))) == Action("Check It", (2,))


def test_what_is_exported_is_sound_pddl_and_reads_back() -> None:
    rng = random.Random(3)
    operators = [Operator(f"act{i}", (X,), (), tuple(_effects(rng, 2, [X]))) for i in range(20)]
    exported = export_domain_and_problem(
        domain(*operators), _state(rng), (ABOVE(Constant("b"), Constant("a_1")),)
    )
    assert check_domain(exported.domain) == ()
    assert check_problem(exported.problem, exported.domain) == ()
    assert read_domain(write_domain(exported.domain)) == exported.domain
    assert read_problem(write_problem(exported.problem)) == exported.problem


def test_tries_are_conditional_effects_one_of_which_must_succeed() -> None:
    tries = (
        OperatorAlternative(RED(X), (missing_step(BIG(X), "small"),), (Delete(RED(X)),)),
        OperatorAlternative(LIT(), (missing_step(CLEAR(X), "covered"),), (Delete(LIT()),)),
    )
    toy = domain(Operator("clean", (X,), (), (), alternatives=tries))
    rng = random.Random(1)
    outcomes = set()
    for _ in range(60):
        initial = _state(rng)
        exported = export_domain_and_problem(toy, initial, ())
        executor = PddlPlanExecutor(exported.domain, exported.problem)
        for thing in range(len(SCENE.objects)):
            action = Action("clean", (thing,))
            found = attempt_action(toy, History(initial), action)
            after = executor.execute_step(executor.initial_state, exported.to_pddl_step(action))
            outcomes.add(isinstance(found, Fault))
            if isinstance(found, Fault):
                assert isinstance(after, str)
            else:
                assert after == exported.export_state(found) | (
                    executor.initial_state - exported.export_state(initial)
                )
    assert outcomes == {True, False}


@pytest.mark.parametrize("chosen", [X, Variable("x", "cup")])
def test_the_first_object_is_one_object_even_if_all_objects_fit(chosen: Variable) -> None:
    toy = domain(Operator("paint", (), (), (Let(chosen, TRUE, (Add(RED(chosen)),)),)))
    initial, action = SCENE.state(()), Action("paint", ())
    exported = export_domain_and_problem(toy, initial, ())
    executor = PddlPlanExecutor(exported.domain, exported.problem)
    after = executor.execute_step(executor.initial_state, exported.to_pddl_step(action))
    painted = toy.apply(initial, action)
    assert len(list(painted.facts())) == 1
    assert after == exported.export_state(painted) | executor.initial_state


TOO_MANY = Exactly(999_999_999, X, RED(X))
PAIRS = ForPairs(Variable("c", "cup"), Variable("d", "cup"), NEAR(Variable("c"), Variable("d")))


@pytest.mark.parametrize(
    "goal",
    [
        *[Exactly(count, X, RED(X)) for count in range(4)],
        TOO_MANY,
        Exactly(1, Variable("x", "cup"), RED(X) & ON(X, AGENT)),
        PAIRS,
        ForPairs(Variable("c", "cup"), Variable("d"), NEAR(Variable("c"), Variable("d"))),
        ForPairs(Variable("c"), Variable("d", "cup"), NEAR(Variable("c"), Variable("d")), 1),
        ForPairs(Variable("c", "cup"), Variable("d", "box"), NEAR(Variable("c"), Variable("d")), 2),
        is_a(Constant("b"), "box") & ForAll(Variable("x", "cup"), BIG(X)),
        ABOVE(Constant("b"), AGENT),
        ABOVE(Constant("b"), Constant("me")),
    ],
)
def test_goals_hold_where_they_hold_in_the_engine(goal: Formula) -> None:
    rng = random.Random(5)
    toy = domain(CHECKED)
    found = set()
    for _ in range(100):
        initial = _state(rng)
        exported = export_domain_and_problem(toy, initial, (goal,))
        executor = PddlPlanExecutor(exported.domain, exported.problem)
        holds = toy.holds(goal, initial)
        assert executor.holds(exported.problem.goal, executor.initial_state, {}) == holds
        found.add(holds)
    impossible = (isinstance(goal, ForPairs) and goal.count == 2) or goal == TOO_MANY
    assert found == ({False} if impossible else {True, False})


def test_goals_about_a_category_without_objects() -> None:
    shoe = Variable("x", "shoe")
    for goal, truth in ((ForAll(shoe, FALSE), True), (Exists(shoe, TRUE), False)):
        exported = export_domain_and_problem(domain(), SCENE.state(()), (goal,))
        executor = PddlPlanExecutor(exported.domain, exported.problem)
        assert executor.holds(exported.problem.goal, executor.initial_state, {}) == truth


def test_a_predicate_named_like_an_added_predicate_keeps_its_meaning() -> None:
    """The export adds predicates for categories, for executed operators and for the order of objects."""
    named = [Predicate(name, 1) for name in ("is-cup", "done-paint", "precedes")]
    vocabulary = Vocabulary(tuple(named))
    first = Let(X, is_a(X, "cup"), (Add(named[0](X)),))
    paint = Operator("paint", (X,), (affordance(is_a(X, "cup"), "no cup"),), (first,))
    initial = Scene(vocabulary, [WorldObject(name, "cup") for name in "ab"]).state([])
    exported = export_domain_and_problem(Domain("toy", vocabulary, (paint,)), initial, (Occurs("paint"),))
    assert check_problem(exported.problem, exported.domain) == ()
    assert check_domain(exported.domain) == ()
    executor = PddlPlanExecutor(exported.domain, exported.problem)
    assert executor.initial_state.isdisjoint(
        Atom(each.name, (Constant(name),)) for each in named for name in "ab"
    )
    after = executor.execute_step(executor.initial_state, PlanStep("paint", ("b",)))
    assert not isinstance(after, str)
    assert after - executor.initial_state == {Atom("is-cup", (Constant("a"),)), Atom("done-paint-2", ())}


def test_goals_on_actions_are_remembered() -> None:
    toy = domain(Operator("rest", (), (), ()), Operator("paint", (X,), (), (Add(RED(X)),)))
    exported = export_domain_and_problem(toy, SCENE.state(()), (Occurs("rest"), RED(Constant("b"))))
    result = search(exported.domain, exported.problem, Limits())
    assert result.end is SearchEndReason.SOLVED
    assert sorted(exported.to_action(step).operator for step in result.plan) == ["paint", "rest"]


def test_what_has_no_formula_is_named_and_keeps_its_initial_value() -> None:
    toy = domain(Operator("paint", (X,), (affordance(ODD(X), "even"),), (Add(RED(X)),)))
    exported = export_domain_and_problem(toy, SCENE.state(()), ())
    assert exported.unsupported == (
        "odd: it is computed by a function and has no formula, so it keeps its initial value",
    )
    assert set(_facts(exported, "odd")) == {"a_1", "b"}


def test_predicates_are_declared_with_all_their_arguments() -> None:
    between = Predicate("between", 4)
    vocabulary = Vocabulary((between,))
    scene = Scene(vocabulary, [WorldObject(name, "cup") for name in "abcd"])
    initial = scene.state([Fact("between", (0, 1, 2, 3))])
    exported = export_domain_and_problem(Domain("toy", vocabulary, ()), initial, ())
    assert check_problem(exported.problem, exported.domain) == ()


def test_invisible_predicates_can_be_left_out() -> None:
    use = Operator(
        "use",
        (X,),
        (missing_step(~RECALLED(X) & BIG(X), "?"),),
        (Add(MEMORY(X)), When(MEMORY(X), (Add(RED(X)),)), Add(BIG(X))),
    )
    toy = domain(use)
    exported = export_problems(
        toy, [ProblemToExport("task", SCENE.state([("memory", (1,))]), ())], with_invisible_predicates=False
    )[0]
    text = write_domain(exported.domain) + write_problem(exported.problem)
    assert "memory" not in text
    assert "recalled" not in text
    assert write_formula(exported.domain.actions[0].precondition) == "(big ?x)"


def test_an_effect_that_depends_on_an_invisible_predicate_does_not_happen() -> None:
    effects = (ForEach(Y, MEMORY(Y), (Add(RED(Y)),)), When(MEMORY(X), (Add(BIG(X)),), (Delete(LIT()),)))
    toy = Domain("toy", VOCABULARY, (Operator("recall", (X,), (), effects, "recall the object"),))
    exported = export_problems(
        toy, [ProblemToExport("task", SCENE.state([]), ())], with_invisible_predicates=False
    )[0]
    (action,) = exported.domain.actions
    assert write_effect(action.effect) == "(not (lit))"


def test_a_problem_may_be_about_some_objects_only() -> None:
    initial = SCENE.state([("RED", (1,)), ("RED", (3,)), ("ON", (1, 3)), ("ON", (0, 1))])
    exported = export_domain_and_problem(domain(CHECKED), initial, (), objects=1 << 1)
    assert {item.name for item in exported.problem.objects} == {"agent", "a_1"}
    assert {fact.arguments for fact in exported.problem.initial} == {
        (Constant("a_1"),),
        (Constant("agent"), Constant("a_1")),
    }


def _facts(exported: ExportedProblem, predicate: str) -> Iterator[str]:
    return (fact.arguments[0].name for fact in exported.problem.initial if fact.predicate == predicate)
