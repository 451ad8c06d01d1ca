"""Chance as a baseline: what the built-in model `eai/random` answers, mostly random possible actions.

It knows what can be done or stated and nothing of what is wanted; how often it succeeds all the same says how
much of a task is luck.
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
from eai.benchmarks.gold_answers import WrittenAnswer, chance, join_of, join_operators, no_answer
from eai.logic.choice import Literal
from eai.logic.formula import And, Atom, Constant, Not, Variable
from eai.logic.ltl_printer import print_ltl
from eai.logic.traversal import walk
from eai.pddl.writer import write_action
from eai.planning.search import Effort, Limits
from eai.planning.successor_generator import applicable_actions
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import USUAL, Source, TaskSet
from eai.tasks.task import Task
from eai.tasks.wording import Wording, subjects
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import attempt, execute
from eai.world.history import History
from eai.world.state import Fact, State

_TRIES = 5_000
"""How many actions are drawn without success before all are looked at."""

_EVEN = 0.5

_USUAL_STEPS = 5
"""How long an answer is where no task has a plan."""


RandomAnswers: TypeAlias = Callable[[str, str, Sequence[Action]], WrittenAnswer]
"""From the id of a task, a seed and what has been executed in its world to the answer."""


def open_random_answers(benchmark: Benchmark, ability: Ability, source: Source = USUAL) -> RandomAnswers:
    """Random answers: plans, what becomes of them step by step, or what they bring about.

    A plan is a random walk: each action is drawn from all that are possible then with the objects that the
    task is about, each equally likely. It is as long as the plan of some task of the data set. Subgoals are
    one visible change of each of its steps, goals what has come about at its end. Operators have random
    literals of their parameters, as many on each side as some operator of the data set.

    Raises:
        DataError: the data cannot be had.
    """
    if ability is Ability.TRANSITION_MODELING:
        return _operators(benchmark.operators(source))
    if ability not in _WRITERS:
        raise no_answer("random", benchmark, ability)
    tasks = benchmark.tasks_for(ability, source)
    public = tasks if benchmark.data.open_public is None else benchmark.data.open_public(source)
    lengths = [len(task.script) for task in public.values() if task.script] or [_USUAL_STEPS]
    write, join = _WRITERS[ability], join_of(benchmark, ability)

    def answer(task_id: str, seed: str, done: Sequence[Action] = ()) -> WrittenAnswer:
        task = tasks[task_id]
        task = replace(task, initial=execute(benchmark.domain, task.initial, done).final) if done else task
        rng = chance(seed, task_id)
        steps = list(random_walk(benchmark.domain, task.initial, task.relevant, rng, rng.choice(lengths)))
        return WrittenAnswer(tuple(write(benchmark, task, steps, rng)), join)

    return answer


def random_walk(
    domain: Domain, initial: State, objects: Sequence[int], rng: random.Random, most: int
) -> Iterator[tuple[Action, State]]:
    """So many random possible actions, each with the state after it; fewer if nothing more is possible."""
    state = initial
    for _ in range(most):
        action = _possible_action(domain, state, objects, rng)
        if action is None:
            return
        state = domain.apply(state, action)
        yield action, state


def _possible_action(
    domain: Domain, state: State, objects: Sequence[int], rng: random.Random
) -> Action | None:
    """Return a possible action, all equally likely, or None if no action is possible.

    If there are too many actions to try all, the first possible ones are equally likely.
    """
    sizes = [len(objects) ** operator.arity for operator in domain.operators]
    for operator in rng.choices(domain.operators, sizes, k=_TRIES):
        action = Action(operator.name, tuple(rng.choices(objects, k=operator.arity)))
        if isinstance(attempt(domain, History(state), action), State):
            return action
    bindings = Effort(Limits().bindings)
    ways = [applicable_actions(domain, each, state, objects, bindings) for each in domain.operators]
    possible = list(chain.from_iterable(ways))
    return rng.choice(possible) if possible else None


_Steps = Sequence[tuple[Action, State]]


def _plan(benchmark: Benchmark, task: Task, steps: _Steps, rng: random.Random) -> Iterable[str]:
    return benchmark.notation.plans.write([action for action, _ in steps], task.scene)


def _subgoals(benchmark: Benchmark, task: Task, steps: _Steps, rng: random.Random) -> Iterable[str]:
    """One of the changes that each step makes."""
    lexicon = benchmark.subgoals().lexicon(task.scene)
    states = [task.initial, *[state for _, state in steps]]
    wording = benchmark.wording(Ability.SUBGOAL_DECOMPOSITION)
    changes = [list(_changes(wording, task, *pair)) for pair in pairwise(states)]
    return [print_ltl(lexicon.worded(rng.choice(of_step))) for of_step in changes if of_step]


def _goals(benchmark: Benchmark, task: Task, steps: _Steps, rng: random.Random) -> Iterable[str]:
    """The goals that have come about at the end."""
    lexicon = GoalLexicon(task, benchmark.domain, benchmark.notation.goals)
    final = steps[-1][1] if steps else task.initial
    wording = benchmark.wording(Ability.GOAL_INTERPRETATION)
    changes = _changes(wording, task, task.initial, final)
    return benchmark.notation.goals.write(
        [lexicon.to_answer_goal(each) for each in changes if isinstance(each, Atom)]
    )


def _changes(wording: Wording, task: Task, before: State, after: State) -> Iterator[Literal]:
    """The facts of which prompts speak that no longer hold, then those that have come to hold."""
    was, is_now = (
        dict.fromkeys([fact for each in wording.listings for fact in each.facts(state, subjects(task))])
        for state in (before, after)
    )
    yield from (Not(_atom_of(fact, task)) for fact in was if fact not in is_now)
    yield from (_atom_of(fact, task) for fact in is_now if fact not in was)


def _atom_of(fact: Fact, task: Task) -> Atom:
    return Atom(fact.predicate, tuple([Constant(task.scene.objects[i].name) for i in fact.arguments]))


def _operators(tasks: TaskSet[TransitionTask]) -> RandomAnswers:
    """Random operators."""
    gold = [action for task in tasks.values() for action in task.gold.values()]
    lengths = [len([part for part in walk(each.precondition) if isinstance(part, Atom)]) for each in gold]
    changes = [len(list(m.effect_atoms(each.effect))) for each in gold]

    def answer(task_id: str, seed: str, done: Sequence[Action] = ()) -> WrittenAnswer:
        task, rng = tasks[task_id], chance(seed, task_id)
        written = []
        for action in task.gold.values():
            can = list(_sayable(task, action))
            asked, made = [
                [_atom(*rng.choice(can), rng) for _ in range(rng.choice(numbers) if can else 0)]
                for numbers in (lengths, changes)
            ]
            needs = And(tuple([atom if rng.random() < _EVEN else Not(atom) for atom in asked]))
            does = tuple([m.Add(atom) if rng.random() < _EVEN else m.Delete(atom) for atom in made])
            written.append(write_action(replace(action, precondition=needs, effect=m.Both(does))))
        return WrittenAnswer(tuple(written), join_operators)

    return answer


def _sayable(task: TransitionTask, action: m.PddlAction) -> Iterator[tuple[str, list[list[str]]]]:
    """The predicates that can be said of an operator's parameters, each with those that fit each place."""
    above = m.parents(task.domain.header.types)
    kinds = {given.name: m.supertypes(above, m.type_of(given)) for given in action.parameters}
    for predicate in task.domain.header.predicates:
        places = [m.type_of(variable) for variable in predicate.parameters]
        fitting = [[name for name, known in kinds.items() if place in known] for place in places]
        if all(fitting):
            yield predicate.name, fitting


def _atom(predicate: str, fitting: Sequence[Sequence[str]], rng: random.Random) -> Atom:
    return Atom(predicate, tuple([Variable(rng.choice(names)) for names in fitting]))


_WRITERS = {
    Ability.ACTION_SEQUENCING: _plan,
    Ability.SUBGOAL_DECOMPOSITION: _subgoals,
    Ability.GOAL_INTERPRETATION: _goals,
}
