from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from eai.base.store import DataPackStore
from eai.benchmarks.published import open_behavior_transition_tasks, open_virtualhome_transition_tasks
from eai.logic.formula import TRUE
from eai.pddl.execute import PddlPlanExecutor, PlanStep
from eai.pddl.grounding import Grounder, GroundProblem
from eai.pddl.model import PddlDomain, PddlProblem, get_variable_type, group_objects_by_type
from eai.pddl.planning import PlannerOutcome, PlanningTask, execute_found_plan
from eai.pddl.reader import read_domain, read_problem
from eai.pddl.search import BuiltInPlanner, _ReachableLiteralPairs, search
from eai.planning.search import Limits, SearchEffort, SearchEndReason
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source
from pddl.random_pddl import DOMAINS, PROBLEMS
from sweeps import examples

EVERYTHING = Limits(100_000, looks=10**9)


def steps(domain: PddlDomain, problem: PddlProblem) -> Iterator[PlanStep]:
    members = group_objects_by_type(domain, problem)
    for action in domain.actions:
        for names in product(
            *(members.get(get_variable_type(parameter), ()) for parameter in action.parameters)
        ):
            yield PlanStep(action.name, names)


def is_solvable(domain: PddlDomain, problem: PddlProblem) -> bool:
    """Breadth-first search over explicit states: slow, and too simple to be wrong."""
    executor = PddlPlanExecutor(domain, problem)
    everything = list(steps(domain, problem))
    waiting, seen = deque([executor.initial_state]), {executor.initial_state}
    while waiting:
        state = waiting.popleft()
        if executor.holds(problem.goal, state, {}):
            return True
        for step in everything:
            after = executor.execute_step(state, step)
            if not isinstance(after, str) and after not in seen:
                seen.add(after)
                waiting.append(after)
    return False


@settings(max_examples=examples(60), deadline=None, suppress_health_check=list(HealthCheck))
@given(DOMAINS, PROBLEMS)
def test_agrees_with_breadth_first_search(domain: PddlDomain, problem: PddlProblem) -> None:
    result = search(domain, problem, EVERYTHING)
    assert result.end is (
        SearchEndReason.SOLVED if is_solvable(domain, problem) else SearchEndReason.UNREACHABLE
    )
    if result.end is SearchEndReason.SOLVED:
        assert PddlPlanExecutor(domain, problem).find_failed_step(result.plan) is None


@settings(max_examples=examples(60), deadline=None, suppress_health_check=list(HealthCheck))
@given(DOMAINS, PROBLEMS, st.integers(0, 300))
def test_however_little_may_be_looked_at_no_verdict_is_wrong(
    domain: PddlDomain, problem: PddlProblem, looks: int
) -> None:
    result = search(domain, problem, replace(EVERYTHING, looks=looks))
    assert result.end in {SearchEndReason.STATES, search(domain, problem, EVERYTHING).end}
    if result.end is SearchEndReason.SOLVED:
        assert PddlPlanExecutor(domain, problem).find_failed_step(result.plan) is None


MACHINE = """(define (domain m) (:predicates (shut) (running) (off) (idle))
(:action start :precondition (off) :effect (and (running) (not (off))))
(:action close :effect (and (shut) (not (running)))) {more})"""
GOAL = "(define (problem p) (:domain m) (:init {init}) (:goal (and (shut) (running))))"


@pytest.mark.parametrize(
    ("more", "init", "verdict"),
    [
        ("", "(off)", SearchEndReason.SOLVED),
        ("", "(running)", SearchEndReason.UNREACHABLE),
        ("(:action stop :precondition (running) :effect (off))", "(running)", SearchEndReason.SOLVED),
        ("", "(running) (shut)", SearchEndReason.SOLVED),
    ],
)
def test_what_the_rest_of_the_goal_destroys_is_achieved_again(
    more: str, init: str, verdict: SearchEndReason
) -> None:
    domain, problem = read_domain(MACHINE.format(more=more)), read_problem(GOAL.format(init=init))
    result = search(domain, problem, EVERYTHING)
    assert result.end is verdict
    assert (result.end is SearchEndReason.SOLVED) is is_solvable(domain, problem)
    assert result.states <= 4


def test_effort_is_bounded_and_the_verdict_then_open() -> None:
    bits = 12
    names = [f"b{i}" for i in range(bits)]
    predicates = " ".join(f"({name})" for name in names)
    flips = "\n".join(
        f"(:action up{i} :precondition (and (not (b{i})) {' '.join(f'(b{j})' for j in range(i))})"
        f" :effect (and (b{i}) {' '.join(f'(not (b{j}))' for j in range(i))}))"
        for i in range(bits)
    )
    domain = read_domain(f"(define (domain counter) (:predicates {predicates}) {flips})")
    goal = " ".join(f"({name})" for name in names)
    problem = read_problem(f"(define (problem p) (:domain counter) (:init) (:goal (and {goal})))")
    assert search(domain, problem, Limits(20)).end is SearchEndReason.STATES
    assert search(domain, problem, Limits(10_000)).end is SearchEndReason.SOLVED
    few = search(domain, problem, Limits(10_000, looks=1_000))
    assert (few.end, few.states < 100) == (SearchEndReason.STATES, True)


def test_alternatives_are_looked_at_too() -> None:
    """A condition of very many alternatives costs as much as equally many operators."""
    names = " ".join("abcdefghijkl")
    domain = read_domain(
        f"""(define (domain wide) (:predicates (near ?x ?y) (done)) (:constants {names})
        (:action act :precondition (exists (?x ?y ?z) (and (near ?x ?y) (near ?y ?z) (near ?z ?x)))
         :effect (done))
        (:action move :parameters (?x ?y) :effect (near ?x ?y)))"""
    )
    problem = read_problem("(define (problem p) (:domain wide) (:init (near a b)) (:goal (done)))")
    assert search(domain, problem, EVERYTHING).end is SearchEndReason.SOLVED
    assert search(domain, problem, replace(EVERYTHING, looks=1_000)).end is SearchEndReason.STATES


def test_equal_input_gives_an_equal_plan(data_store: DataPackStore) -> None:
    task = gold_tasks(data_store)[0]
    made = with_gold_operators(task)
    assert search(made.domain, made.problem, Limits()) == search(made.domain, made.problem, Limits())


def with_gold_operators(task: TransitionTask) -> PlanningTask:
    return PlanningTask(
        replace(task.domain.header, actions=tuple(task.gold_operators.values())), task.problem
    )


def gold_tasks(store: DataPackStore) -> list[TransitionTask]:
    return [
        *open_virtualhome_transition_tasks(Source(store)).values(),
        *open_behavior_transition_tasks(Source(store)).values(),
    ]


def test_solves_all_gold_problems(data_store: DataPackStore) -> None:
    for task in gold_tasks(data_store):
        made = with_gold_operators(task)
        result = search(made.domain, made.problem, Limits())
        assert result.end is SearchEndReason.SOLVED, task.id
        assert PddlPlanExecutor(made.domain, made.problem).find_failed_step(result.plan) is None


DERIVED = """(define (domain d) (:predicates (on ?x ?y) (wet ?x) (clear ?x) (above ?x ?y))
    (:derived (clear ?x) (not (exists (?y) (on ?y ?x)))) {more}
    (:action splash :parameters (?x) :precondition (clear ?x) :effect (wet ?x))
    (:action lift :parameters (?x ?y) :precondition (and (clear ?x) (on ?x ?y)) :effect (not (on ?x ?y))))"""
STACKED = read_problem(
    """(define (problem p) (:domain d) (:objects a b c)
    (:init (on a b) (on b c)) (:goal (and (wet c) (clear b))))"""
)


def test_derived_predicates_are_unfolded() -> None:
    domain = read_domain(DERIVED.format(more=""))
    result = search(domain, STACKED, Limits())
    assert result.end is SearchEndReason.SOLVED
    assert PddlPlanExecutor(domain, STACKED).find_failed_step(result.plan) is None
    assert len(result.plan) == 3


def test_a_derived_predicate_that_depends_on_itself_is_for_another_planner() -> None:
    above = "(:derived (above ?x ?y) (or (on ?x ?y) (exists (?z) (and (on ?x ?z) (above ?z ?y)))))"
    task = PlanningTask(read_domain(DERIVED.format(more=above)), STACKED)
    assert BuiltInPlanner().solve(task).outcome is PlannerOutcome.UNSUPPORTED


EIGHT = " ".join(f"?x{i}" for i in range(8))
PAIRS = "(near ?x0 ?x1) (near ?x2 ?x3) (near ?x4 ?x5) (near ?x6 ?x7)"


@pytest.mark.parametrize(
    ("parameters", "precondition", "effect"),
    [
        (EIGHT, f"(and {PAIRS})", "(and (done) (near ?x0 ?x7))"),
        ("", f"(forall ({EIGHT}) (or {PAIRS} (done)))", "(done)"),
        ("", f"(exists ({EIGHT}) (and {PAIRS} (not (near ?x0 ?x7))))", "(and (done) (not (near a a)))"),
        ("", "()", f"(forall ({EIGHT}) (when (or {PAIRS}) (done)))"),
    ],
)
def test_work_is_bounded_however_many_variables_there_are(
    parameters: str, precondition: str, effect: str
) -> None:
    names = " ".join("abcdefghijkl")
    domain = read_domain(
        f"""(define (domain wide) (:predicates (near ?x ?y) (done)) (:constants {names})
        (:action act :parameters ({parameters}) :precondition {precondition} :effect {effect})
        (:action move :parameters (?x ?y) :effect (near ?x ?y)))"""
    )
    problem = read_problem("(define (problem p) (:domain wide) (:init (near a b)) (:goal (done)))")
    assert search(domain, problem, Limits()).end is SearchEndReason.STATES
    result = BuiltInPlanner().solve(PlanningTask(domain, problem))
    assert (result.outcome, result.plan) == (PlannerOutcome.TIME, ())


@pytest.mark.parametrize(
    ("precondition", "effect", "outcome"),
    [
        (f"(forall ({EIGHT}) (near a b))", f"(forall ({EIGHT}) (done))", PlannerOutcome.SOLVED),
        (f"(not (exists ({EIGHT}) (near a b)))", "(done)", PlannerOutcome.UNSOLVABLE),
        ("()", f"(forall ({EIGHT}) (when (forall ({EIGHT}) (near a ?x3)) (done)))", PlannerOutcome.SOLVED),
        ("(exists (?n - nobody) (near a b))", "(done)", PlannerOutcome.UNSOLVABLE),
        ("()", "(forall (?n - nobody) (done))", PlannerOutcome.UNSOLVABLE),
        ("()", "(and (forall (?n) (when (near a ?n) (and))) (done))", PlannerOutcome.SOLVED),
    ],
)
def test_quantifiers_that_nothing_is_said_of_cost_nothing(
    precondition: str, effect: str, outcome: PlannerOutcome
) -> None:
    names = " ".join("abcdefghijkl")
    domain = read_domain(
        f"""(define (domain wide) (:types nobody - object) (:predicates (near ?x ?y) (done))
        (:constants {names} - object)
        (:action act :precondition {precondition} :effect {effect}))"""
    )
    near = " ".join(f"(near a {name})" for name in "abcdefghijkl")
    problem = read_problem(f"(define (problem p) (:domain wide) (:init {near}) (:goal (done)))")
    assert BuiltInPlanner().solve(PlanningTask(domain, problem)).outcome is outcome


def test_a_plan_that_takes_too_long_to_execute_is_not_judged() -> None:
    everywhere = f"(forall ({EIGHT}) (or {PAIRS} (not (near ?x0 ?x7)) (not (near ?x1 ?x6)) (done)))"
    names = " ".join("abcdefghijkl")
    near = " ".join(f"(near {x} {y})" for x in "abcdefghijkl" for y in "abcdefghijkl")
    domain = read_domain(
        f"""(define (domain wide) (:predicates (near ?x ?y) (done)) (:constants {names})
        (:action act :precondition {everywhere} :effect (done)))"""
    )
    problem = read_problem(f"(define (problem p) (:domain wide) (:init {near}) (:goal (done)))")
    result = execute_found_plan(PlanningTask(domain, problem), [PlanStep("act", ())], "a planner")
    assert result.outcome is PlannerOutcome.TIME
    assert result.detail == "a planner: its plan takes too long to execute"


@settings(max_examples=examples(100), deadline=None, suppress_health_check=list(HealthCheck))
@given(DOMAINS, PROBLEMS)
def test_what_holds_together_somewhere_is_allowed(domain: PddlDomain, problem: PddlProblem) -> None:
    grounder = Grounder(domain, replace(problem, goal=TRUE))
    goal, actions = grounder.goal(), list(grounder.generate_actions())
    assert goal is not None
    ground = GroundProblem(grounder, actions, goal, SearchEffort())
    pairs = _ReachableLiteralPairs(ground, SearchEffort())
    waiting, seen = [ground.initial], {ground.initial}
    while waiting and len(seen) < 200:
        state = waiting.pop()
        assert pairs.may_hold_together(ground.find_state_literals(state))
        found = {
            after for _, after in ground.generate_successors(state, ground.find_state_literals(state))
        } - seen
        seen |= found
        waiting += sorted(found)


HOUSE = read_domain(
    """(define (domain house) (:predicates (held ?x) (full) (at ?x) (lit ?x) (spare))
    (:action take :parameters (?x) :precondition (and (at ?x) (not (full))) :effect (and (held ?x) (full)))
    (:action drop :parameters (?x) :precondition (held ?x) :effect (and (not (held ?x)) (not (full))))
    (:action go :parameters (?x) :effect (and (at ?x) (forall (?y) (when (not (= ?x ?y)) (not (at ?y))))))
    (:action light :parameters (?x) :precondition (at ?x) :effect (lit ?x))
    (:action swap :effect (and (when (spare) (not (spare))) (when (not (spare)) (spare)))))"""
)
LIT = " ".join(f"(lit {name})" for name in "abcdefghijkl")


@pytest.mark.parametrize(
    ("goal", "is_allowed"),
    [
        ("(and (held a) (held b))", False),
        ("(and (held a) (not (full)))", False),
        ("(and (at a) (at b))", False),
        ("(and (held a) (at b))", True),
        ("(and (held a) (not (held b)))", True),
        ("(and (spare) (lit a))", True),
        ("(and (not (at a)) (not (at b)) (not (at c)))", True),  # no pair of them is impossible
        ("(or (held a) (held b))", True),
    ],
)
def test_pairs_tell_what_one_hand_cannot_hold(goal: str, is_allowed: bool) -> None:
    problem = read_problem(f"(define (problem p) (:domain house) (:objects a b c) (:init) (:goal {goal}))")
    grounder = Grounder(HOUSE, problem)
    condition = grounder.goal()
    assert condition is not None
    ground = GroundProblem(grounder, list(grounder.generate_actions()), condition, SearchEffort())
    looks = SearchEffort()
    assert _ReachableLiteralPairs(ground, looks).may_hold_together(ground.goal) is is_allowed
    assert _ReachableLiteralPairs(ground, SearchEffort(looks.used // 2)).may_hold_together(ground.goal)


@pytest.mark.parametrize(
    ("goal", "verdict"),
    [
        (f"(and {LIT} (held a) (held b))", SearchEndReason.UNREACHABLE),
        (f"(and {LIT} (held a) (at b))", SearchEndReason.SOLVED),
    ],
)
def test_what_pairs_exclude_is_not_searched_for(goal: str, verdict: SearchEndReason) -> None:
    names = " ".join("abcdefghijkl")
    problem = read_problem(f"(define (problem p) (:domain house) (:objects {names}) (:init) (:goal {goal}))")
    result = search(HOUSE, problem, Limits())
    assert result.end is verdict
    assert result.states <= 60


ONE = Limits(1)
KITCHEN = read_domain(
    """(define (domain house)
    (:predicates (at ?x) (held ?x) (full) (in ?x ?y) (open ?y) (beside ?x ?y))
    (:action go :parameters (?x) :effect (and (forall (?y) (not (at ?y))) (at ?x)))
    (:action take :parameters (?x) :precondition (and (at ?x) (not (full))
      (forall (?y) (or (open ?y) (not (in ?x ?y)))))
     :effect (and (held ?x) (full)
      (forall (?y) (and (not (in ?x ?y)) (not (beside ?x ?y)) (not (beside ?y ?x))))))
    (:action put :parameters (?x ?y) :precondition (and (held ?x) (at ?y) (open ?y))
     :effect (and (not (held ?x)) (not (full)) (in ?x ?y)))
    (:action join :parameters (?x ?y) :precondition (and (held ?x) (at ?y))
     :effect (and (not (held ?x)) (not (full)) (beside ?x ?y) (beside ?y ?x)))
    (:action open :parameters (?y) :precondition (and (at ?y) (not (full))) :effect (open ?y))
    (:action shut :parameters (?y) :precondition (at ?y) :effect (not (open ?y))))"""
)


@pytest.mark.parametrize(
    ("initial", "goal", "length"),
    [
        # each thing is brought to the box by itself, though a relaxed plan goes there but once
        ("(open box)", "(and (in cup box) (in jar box) (in pan box))", 12),
        # the box is opened before a hand is full, and shut last
        ("(at cup)", "(and (in cup box) (in jar box) (not (open box)))", 12),
        # what has been done at one place is done again where it is lost
        ("(in cup box)", "(and (at box) (in cup pot) (open pot))", 9),
        # the cup, which every thing may be put beside, is not taken away again
        ("(in jar box) (in pan box)", "(and (beside jar cup) (beside pan cup) (beside pot cup))", 15),
    ],
)
def test_one_state_is_enough_where_parts_of_the_goal_can_be_reached_one_after_the_other(
    initial: str, goal: str, length: int
) -> None:
    head = "(:domain house) (:objects cup jar pan pot box)"
    problem = read_problem(f"(define (problem p) {head} (:init {initial}) (:goal {goal}))")
    result = search(KITCHEN, problem, ONE)
    assert (result.end, result.states) == (SearchEndReason.SOLVED, 1)
    assert PddlPlanExecutor(KITCHEN, problem).find_failed_step(result.plan) is None
    assert len(result.plan) <= length


def test_a_derived_predicate_that_depends_on_itself_is_undecided() -> None:
    domain = read_domain(
        "(define (domain d) (:predicates (link ?x ?y) (joined ?x ?y))"
        " (:derived (joined ?x ?y) (or (link ?x ?y) (exists (?z) (and (link ?x ?z) (joined ?z ?y)))))"
        " (:action tie :parameters (?x ?y) :effect (link ?x ?y)))"
    )
    problem = read_problem("(define (problem p) (:domain d) (:objects a b) (:init) (:goal (joined a b)))")
    assert search(domain, problem, EVERYTHING).end is SearchEndReason.STATES
