"""Make the example task for prompts of domains without a data set.

An evaluated task is never the example, so no prompt shows its plan.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from itertools import islice

import eai.logic.formula as f
from eai.logic.ltl_printer import format_ltl
from eai.planning.search import SearchEffort
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.goal_test import solves_task
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import State, compare_states

_MAX_PLANS = 50
"""Maximum number of plans that are tried to make an example task."""

_MAX_BINDINGS = 20_000
"""Maximum number of combinations of parameter values that are tried to find possible actions in a state."""


def make_example_task_for_prompts(
    domain: Domain, evaluated_tasks: Collection[Task], goal_predicates: Collection[str]
) -> Task | None:
    """Return a task of two actions, or one, in the scene of the first task; None if no such task exists.

    A second action is possible only after the first. The goal is a fact that the last action makes true. The
    plan does not solve any of the given tasks.

    Args:
        domain: the domain.
        evaluated_tasks: the evaluated tasks, at least one.
        goal_predicates: the predicates of goals.
    """
    first = next(iter(evaluated_tasks))
    for plan, final in islice(_yield_short_plans_with_final_states(domain, first), _MAX_PLANS):
        facts = [
            fact for fact in compare_states(first.initial, final).added if fact.predicate in goal_predicates
        ]
        if facts and not any(
            task.scene.objects == first.scene.objects and solves_task(domain, task, plan)
            for task in evaluated_tasks
        ):
            predicate, arguments = facts[-1]
            wanted = f.Atom(predicate, tuple([f.Constant(first.scene.objects[i].name) for i in arguments]))
            said = f"Reach a state in which this holds: {format_ltl(wanted)}"
            asked = Task("example", "Example", said, first.initial, (goal(wanted),), first.relevant, plan)
            return replace(asked, unnamed=first.unnamed)
    return None


def _yield_short_plans_with_final_states(
    domain: Domain, task: Task
) -> Iterator[tuple[tuple[Action, ...], State]]:
    """Yield plans with their final states: first plans of two actions, then plans of one action.

    In a plan of two actions, the second action is possible only after the first action.
    """
    starting = _list_applicable_actions(domain, task, task.initial)
    possible = frozenset(starting)
    after = {action: domain.apply(task.initial, action) for action in starting}
    for action, state in after.items():
        for last in _list_applicable_actions(domain, task, state):
            if last not in possible:
                yield (action, last), domain.apply(state, last)
    for action, state in after.items():
        yield (action,), state


def _list_applicable_actions(domain: Domain, task: Task, state: State) -> list[Action]:
    effort = SearchEffort(_MAX_BINDINGS)
    return [
        action
        for operator in domain.operators
        for action in generate_applicable_actions_of_operator(domain, operator, state, task.relevant, effort)
    ]
