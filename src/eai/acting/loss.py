"""Lost for good: whether the goals can still be reached after each turn of an episode.

Nothing that can be reached later could not be reached before, so the first turn after which the goals are
out of reach is found by bisection.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from eai.abilities.goal_test import remaining_goals
from eai.abilities.planning import find_plan
from eai.abilities.task import Task
from eai.acting.declaration import Outlook
from eai.envs.agents import planner_of
from eai.planning.search import Limits, SearchEnd
from eai.world.domain import Domain
from eai.world.state import State

Moment: TypeAlias = tuple[State, Sequence[str]]
"""The world after a turn, and the operators of the actions that were carried out so far."""


def loss(task: Task, domain: Domain, moments: Sequence[Moment], states: int) -> tuple[Outlook, int | None]:
    """Whether the goals can still be reached at the end, and else the first turn after which they cannot.

    Who acts may use all objects of the scene, seen or not, and any number of actions. A plan shows that the
    goals can be reached, and a search of all that actions lead to that they cannot. Of goals over time the
    first is never shown.

    Args:
        task: the task.
        domain: the world.
        moments: the start, and the world after each turn.
        states: how many states each search may reach; if that does not do, nothing is known.
    """
    last = _outlook(task, domain, moments[-1], states)
    if last != "lost":
        return last, None
    return last, bisect_left(moments[:-1], True, key=lambda at: _outlook(task, domain, at, states) == "lost")


def _outlook(task: Task, domain: Domain, moment: Moment, states: int) -> Outlook:
    state, taken = moment
    now = replace(task, initial=state, goals=remaining_goals(task, taken))
    end = SearchEnd.STATES
    for objects in (task.relevant, tuple(range(len(task.scene.objects)))):
        end = find_plan(replace(now, relevant=objects), planner_of(domain), Limits(states)).end
        if end is SearchEnd.SOLVED:
            is_over_time = any(goal.is_over_time for goal in task.goals)
            return "unknown" if is_over_time else "open"
    return "lost" if end is SearchEnd.UNREACHABLE else "unknown"
