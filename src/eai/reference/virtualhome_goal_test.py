"""Which goals a VirtualHome plan reaches, as eai-eval 1.0.5 finds out (``eval_utils.py``).

- Its loop over relation goals ends at the first one that holds (``scene_evaluate_wID``): at most one counts.
- It looks for action goals as substrings of the text of all actions, and takes the first alternative that
  occurs, not the earliest place (``check_order_with_or_score``). The first goal that is not found ends it.
- It looks for them in the order of a set of strings, which changes from run to run. Row verdicts take the
  order of hash seed 0, which for the 13 tasks with two action goals is the alphabetical one.
"""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.goal_test import GoalTest
from eai.abilities.task import GoalKind, Task
from eai.world.execution import Trajectory
from eai.world.state import State


class VirtualHomeGoalTest(GoalTest):
    """The reference's test of a task's goals.

    Args:
        task: the task.
        as_in_data_set: whether action goals are looked for in the order of the data set.
    """

    def __init__(self, task: Task, *, as_in_data_set: bool = False) -> None:
        super().__init__(task)
        numbers = range(len(self._actions))
        self._order = numbers if as_in_data_set else sorted(numbers, key=self._actions.__getitem__)
        self._relations = [i for i, goal in enumerate(task.goals) if goal.kind is GoalKind.RELATION]
        self.reorders = list(self._order) != list(numbers)

    def reached(
        self, final: State, actions: Sequence[str], course: Trajectory | None = None
    ) -> tuple[bool, ...]:
        """For each goal, in order, whether it counts: of relation goals the first that holds."""
        reached = list(super().reached(final, actions, course))
        held = [number for number in self._relations if reached[number]]
        for number in held[1:]:
            reached[number] = False
        return tuple(reached)

    def passes_gold_test(self, final: State) -> bool:
        """Whether all state and relation goals count as reached in the annotation's own final state."""
        reached = self.reached(final, ())
        return all(reached[i] for i in range(len(reached)) if i not in self._places)

    def _met(self, goals: Sequence[tuple[str, ...]], actions: Sequence[str]) -> Sequence[int]:
        """The action goals before the first that is not found."""
        text = " ".join(actions)
        position = 0
        for count, number in enumerate(self._order):
            found = next((word for word in goals[number] if text.find(word, position) >= 0), None)
            if found is None:
                return self._order[:count]
            position = text.find(found, position) + len(found)
        return self._order
