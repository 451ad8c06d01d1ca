"""A random baseline: the built-in model `eai/random` answers with random possible actions.

The model knows which actions are possible and which facts goals may state, but not the goals. Its success
rate shows how many tasks can be solved by luck.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import TypeAlias

import eai.pddl.model as m
from eai.abilities.notation.goal_lexicon import GoalLexicon
from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import (
    AnswerInParts,
    get_function_that_joins_answer_parts,
    join_operators_as_answer,
    make_no_answer_error,
    make_random_generator,
)
from eai.logic.choice import Literal
from eai.logic.formula import And, Atom, Constant, Not, Variable
from eai.logic.ltl_printer import format_ltl
from eai.logic.traversal import walk_subformulas
from eai.pddl.writer import write_action
from eai.planning.search import Limits, SearchEffort
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import USUAL_SOURCE, Source, TaskSet
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording, list_objects_in_prompt
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import attempt_action, execute_plan
from eai.world.history import History
from eai.world.state import Fact, State

_MAX_DRAWS = 5_000
"""Maximum number of random draws of an action.

If all drawn actions are impossible, possible ones are listed.
"""

_HALF = 0.5

_DEFAULT_STEPS = 5
"""Number of actions of a random plan if no task of the data set has a plan."""


RandomAnswers: TypeAlias = Callable[[str, str, Sequence[Action]], AnswerInParts]
"""Returns a random answer, given a task id, a seed, and the actions that have been executed before."""


def open_random_answers(
    benchmark: Benchmark, ability: Ability, source: Source = USUAL_SOURCE
) -> RandomAnswers:
    """Return a function that gives random answers of an ability.

    A plan is a random walk: each action is drawn with equal probability from all possible actions on relevant
    objects. The plan is as long as the plan of a random task of the data set. Subgoals are visible
    changes of such a walk, one for each step. Goals are the changes between the start and the end of a walk.
    Preconditions and effects of operators are random literals over their parameters. The number of literals
    is that of a random operator of the data set.

    Raises:
        DataError: the data cannot be obtained.
    """
    if ability is Ability.TRANSITION_MODELING:
        return _make_random_operator_answers(benchmark.operator_tasks(source))
    if ability not in _WRITERS:
        raise make_no_answer_error(model="random", benchmark=benchmark, ability=ability)
    tasks = benchmark.tasks_for(ability, source)
    public = tasks if benchmark.data.open_public is None else benchmark.data.open_public(source)
    lengths = [len(task.script) for task in public.values() if task.script] or [_DEFAULT_STEPS]
    write, join = _WRITERS[ability], get_function_that_joins_answer_parts(benchmark, ability)

    def make_random_answer(task_id: str, seed: str, executed_actions: Sequence[Action] = ()) -> AnswerInParts:
        task = tasks[task_id]
        if executed_actions:
            state = execute_plan(benchmark.domain, task.initial, executed_actions).final_state
            task = replace(task, initial=state)
        rng = make_random_generator(seed, task_id)
        steps = list(random_walk(benchmark.domain, task.initial, task.relevant, rng, rng.choice(lengths)))
        return AnswerInParts(tuple(write(benchmark, task, steps, rng)), join)

    return make_random_answer


def random_walk(
    domain: Domain, initial: State, objects: Sequence[int], rng: random.Random, max_steps: int
) -> Iterator[tuple[Action, State]]:
    """Yield at most ``max_steps`` random possible actions, each with the state after the action.

    Stop if no action is possible.
    """
    state = initial
    for _ in range(max_steps):
        action = _draw_action(domain, state, objects, rng)
        if action is None:
            return
        state = domain.apply(state, action)
        yield action, state


def _draw_action(domain: Domain, state: State, objects: Sequence[int], rng: random.Random) -> Action | None:
    """Return a random possible action, or None if no action is possible.

    All possible actions have equal probability. If listing all possible actions exceeds a limit, only the
    listed actions can be drawn.
    """
    sizes = [len(objects) ** operator.arity for operator in domain.operators]
    if not any(sizes):
        return None
    for operator in rng.choices(domain.operators, sizes, k=_MAX_DRAWS):
        action = Action(operator.name, tuple(rng.choices(objects, k=operator.arity)))
        if isinstance(attempt_action(domain, History(state), action), State):
            return action
    bindings = SearchEffort(Limits().bindings)
    ways = [
        generate_applicable_actions_of_operator(domain, operator, state, objects, bindings)
        for operator in domain.operators
    ]
    possible = list(chain.from_iterable(ways))
    return rng.choice(possible) if possible else None


_RandomWalkSteps = Sequence[tuple[Action, State]]


def _write_plan(
    benchmark: Benchmark, task: Task, steps: _RandomWalkSteps, rng: random.Random
) -> Iterable[str]:
    return benchmark.notation.plans.write([action for action, _ in steps], task.scene)


def _write_subgoals(
    benchmark: Benchmark, task: Task, steps: _RandomWalkSteps, rng: random.Random
) -> Iterable[str]:
    """Return subgoals: for each step, one random fact that the step changes and that prompts show."""
    lexicon = benchmark.subgoal_notation().make_lexicon_of_names_in_subgoals(task.scene)
    states = [task.initial, *[state for _, state in steps]]
    wording = benchmark.wording(Ability.SUBGOAL_DECOMPOSITION)
    changes = [list(_list_changed_facts(wording, task, *pair)) for pair in pairwise(states)]
    return [
        format_ltl(lexicon.replace_domain_names_by_lexicon_names(rng.choice(of_step)))
        for of_step in changes
        if of_step
    ]


def _write_facts_that_became_true_as_goals(
    benchmark: Benchmark, task: Task, steps: _RandomWalkSteps, rng: random.Random
) -> Iterable[str]:
    """Return the facts that became true from the start to the end, as an answer to goal interpretation."""
    lexicon = GoalLexicon(task, benchmark.domain, benchmark.notation.goals)
    final = steps[-1][1] if steps else task.initial
    wording = benchmark.wording(Ability.GOAL_INTERPRETATION)
    changes = _list_changed_facts(wording, task, task.initial, final)
    return benchmark.notation.goals.write(
        [lexicon.to_goal_with_answer_names(change) for change in changes if isinstance(change, Atom)]
    )


def _list_changed_facts(
    wording: PromptAndAnswerWording, task: Task, before: State, after: State
) -> Iterator[Literal]:
    """Yield the negations of facts that became false between two states, then facts that became true.

    Only facts that prompts show count.
    """
    facts_before, facts_after = (
        dict.fromkeys(
            [
                fact
                for listing in wording.fact_listers_of_goal_predicates
                for fact in listing.list_facts(state, list_objects_in_prompt(task))
            ]
        )
        for state in (before, after)
    )
    yield from (
        Not(_make_atom_with_object_names(fact, task)) for fact in facts_before if fact not in facts_after
    )
    yield from (_make_atom_with_object_names(fact, task) for fact in facts_after if fact not in facts_before)


def _make_atom_with_object_names(fact: Fact, task: Task) -> Atom:
    return Atom(fact.predicate, tuple([Constant(task.scene.objects[i].name) for i in fact.arguments]))


def _make_random_operator_answers(tasks: TaskSet[TransitionTask]) -> RandomAnswers:
    gold = [action for task in tasks.values() for action in task.gold_operators.values()]
    lengths = [
        len([formula for formula in walk_subformulas(action.precondition) if isinstance(formula, Atom)])
        for action in gold
    ]
    changes = [len(list(m.find_effect_atoms(action.effect))) for action in gold]

    def make_random_answer(task_id: str, seed: str, executed_actions: Sequence[Action] = ()) -> AnswerInParts:
        task, rng = tasks[task_id], make_random_generator(seed, task_id)
        written = []
        for action in task.gold_operators.values():
            predicates = list(list_predicates_with_arguments(task, action))
            needed, changed = [
                [
                    _draw_atom(*rng.choice(predicates), rng)
                    for _ in range(rng.choice(numbers) if predicates else 0)
                ]
                for numbers in (lengths, changes)
            ]
            needs = And(tuple([atom if rng.random() < _HALF else Not(atom) for atom in needed]))
            does = tuple([m.Add(atom) if rng.random() < _HALF else m.Delete(atom) for atom in changed])
            written.append(write_action(replace(action, precondition=needs, effect=m.AndEffect(does))))
        return AnswerInParts(tuple(written), join_operators_as_answer)

    return make_random_answer


def list_predicates_with_arguments(
    task: TransitionTask, action: m.PddlAction
) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield each predicate, and for each of its arguments the operator's parameters of a fitting type.

    Predicates with an argument for which the operator has no parameter are left out.
    """
    above = m.map_types_to_parents(task.domain.header.types)
    kinds = {given.name: m.list_supertypes(above, m.get_variable_type(given)) for given in action.parameters}
    for predicate in task.domain.header.predicates:
        types = [m.get_variable_type(variable) for variable in predicate.parameters]
        fitting = [[name for name, supertypes in kinds.items() if wanted in supertypes] for wanted in types]
        if all(fitting):
            yield predicate.name, fitting


def _draw_atom(predicate: str, fitting: Sequence[Sequence[str]], rng: random.Random) -> Atom:
    return Atom(predicate, tuple([Variable(rng.choice(names)) for names in fitting]))


_WRITERS = {
    Ability.ACTION_SEQUENCING: _write_plan,
    Ability.SUBGOAL_DECOMPOSITION: _write_subgoals,
    Ability.GOAL_INTERPRETATION: _write_facts_that_became_true_as_goals,
}
