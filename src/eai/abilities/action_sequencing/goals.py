"""Which goals hold at the end of a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice

from eai.abilities.protocol import Protocol
from eai.abilities.task import Goal, GoalKind, Task
from eai.abilities.verdict import GoalTallies, Json, Tally
from eai.logic.formula import Occurs, Or
from eai.world.condition import Conditions
from eai.world.frame import Frame
from eai.world.state import State


class TaskGoals:
    """The goals of a task, ready to be checked against a final state and the actions taken.

    Three quirks of eai-eval 1.0.5 live here. Its loop over relation goals ends at the first one that holds
    (``scene_evaluate_wID``), so that at most one counts. It looks for action goals as substrings and takes
    the first alternative that occurs, not the earliest place (``check_order_with_or_score``). And it looks
    for them in the order of a set of strings, which changes from run to run; row verdicts take the order of
    hash seed 0, which for the 13 tasks with two action goals is the alphabetical one.
    """

    def __init__(self, task: Task, protocol: Protocol) -> None:
        as_in_reference = protocol is Protocol.EAI_1_0_5
        self._most_relations = 1 if as_in_reference else None
        self._count_actions = _first_found_in_text if as_in_reference else _longest_in_order
        self._tests = {goal: _test(task, goal) for goal in task.goals if goal.kind is not GoalKind.ACTION}
        self._goals = task.goals
        self._states = tuple(self._tests[goal] for goal in task.goals_of(GoalKind.STATE))
        self._relations = tuple(self._tests[goal] for goal in task.goals_of(GoalKind.RELATION))
        self._actions = tuple(_alternatives(goal) for goal in task.goals_of(GoalKind.ACTION))
        self._ordered_actions = tuple(sorted(self._actions)) if as_in_reference else self._actions

    def count(self, state: State, actions: Sequence[str]) -> GoalTallies:
        """Count the goals that hold in a final state, after these actions (names, in order).

        Action goals count in their order: each must be found after the one before.
        """
        return GoalTallies(
            Tally(sum([holds(state) for holds in self._states]), len(self._states)),
            Tally(self._count_relations(state), len(self._relations)),
            Tally(self._count_actions(self._ordered_actions, actions), len(self._actions)),
        )

    def satisfied(self, state: State, actions: Sequence[str]) -> list[bool]:
        """For each goal of the task, in order, whether it holds; an action goal counts by itself."""
        return [
            bool(self._count_actions([_alternatives(goal)], actions))
            if goal.kind is GoalKind.ACTION
            else self._tests[goal](state)
            for goal in self._goals
        ]

    def count_actions_singly(self, actions: Sequence[str]) -> Tally:
        """Count the action goals before the first that no action meets, whatever the order of the actions."""
        met = [not set(alternatives).isdisjoint(actions) for alternatives in self._actions]
        return Tally((*met, False).index(False), len(met))

    def in_data_set_order(self, goals: GoalTallies, actions: Sequence[str]) -> Mapping[str, Json] | None:
        """What ``goals`` would be with the action goals in data set order, if that is another order."""
        if self._ordered_actions == self._actions:
            return None
        in_order = goals._replace(
            action=Tally(self._count_actions(self._actions, actions), len(self._actions))
        )
        return {"data_set_order": {"success": in_order.all_satisfied, "action": list(in_order.action)}}

    def none_satisfied(self) -> GoalTallies:
        """The tallies of an answer that never ran."""
        return GoalTallies(
            *(Tally(0, len(goals)) for goals in (self._states, self._relations, self._actions))
        )

    def hold_in(self, state: State) -> bool:
        """Whether all state and relation goals count as satisfied in a state."""
        every_state = all(holds(state) for holds in self._states)
        return every_state and self._count_relations(state) == len(self._relations)

    def _count_relations(self, state: State) -> int:
        satisfied = (holds for holds in self._relations if holds(state))
        return sum(1 for _ in islice(satisfied, self._most_relations))


def _test(task: Task, goal: Goal) -> Callable[[State], bool]:
    frame = Frame()
    truth = Conditions(task.scene.vocabulary, frame).truth(goal.formula)
    return partial(_holds, truth, frame.bind(task.scene, ()))


def _holds(truth: Callable[[State, list[int]], bool], binding: list[int], state: State) -> bool:
    return truth(state, binding)


def _alternatives(goal: Goal) -> tuple[str, ...]:
    operands = goal.formula.operands if isinstance(goal.formula, Or) else (goal.formula,)
    return tuple(operand.action for operand in operands if isinstance(operand, Occurs))


def _first_found_in_text(goals: Sequence[tuple[str, ...]], actions: Sequence[str]) -> int:
    """How many goals are found before the first that is not; the first alternative that is found counts."""
    text = " ".join(actions)
    position = 0
    for count, alternatives in enumerate(goals):
        found = next((w for w in alternatives if text.find(w, position) >= 0), None)
        if found is None:
            return count
        position = text.find(found, position) + len(found)
    return len(goals)


def _longest_in_order(goals: Sequence[tuple[str, ...]], actions: Sequence[str]) -> int:
    """The length of the longest subsequence of the goals that the actions meet in order."""
    best = [0] * (len(goals) + 1)
    for action in actions:
        for i in range(len(goals), 0, -1):
            if action in goals[i - 1]:
                best[i] = max(best[i], best[i - 1] + 1)
        for i in range(1, len(best)):
            best[i] = max(best[i], best[i - 1])
    return best[-1]
