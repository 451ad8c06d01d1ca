"""Episodes: actions are tried in a world one after the other.

A possible action may slip, that is, by chance have no effect.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TypeAlias

from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, attempt_action
from eai.world.fault import FaultKind, Notice
from eai.world.history import History
from eai.world.state import State


@dataclass(frozen=True, slots=True)
class Slip:
    """An action that was possible but by chance had no effect."""


Outcome: TypeAlias = State | Fault | Slip
"""Outcome of an action: the state after the action, its fault, or a slip (by chance no effect)."""


KnownOutcomes: TypeAlias = "dict[Action, tuple[State | Fault, KnownOutcomes]]"
"""Cache of the outcomes of actions in a state.

An entry maps an action to its outcome, and to another such cache for the state after the action. Episodes
with equal beginnings may share a cache, so that each step is computed once.
"""


class SlipSampler:
    """Draws at random whether possible actions slip (have no effect), in one answer to one task.

    There is no draw for an impossible action. So the n-th possible action gets the same draw under any
    policy. Episodes that share a sampler continue its sequence of draws (paper "Embodied Agent
    Interface", appendix on replanning with stochastic actions).

    Args:
        probability: probability that a possible action slips, from 0 to 1, independent of other actions.
        task_id: the task; each task has its own draws.
        seed: seed of the draws.
        epoch: number of the answer among several answers to the task; each answer has its own draws.
        notice: whether the agent notices a slip.
    """

    def __init__(
        self, probability: float, task_id: str, *, seed: int = 0, epoch: int = 0, notice: Notice = "detected"
    ) -> None:
        self.notice = notice
        self._probability = probability
        stream = hashlib.sha256(f"{seed} {task_id} {epoch}".encode()).digest()
        self._random = random.Random(stream)  # noqa: S311 - chance, not secrets

    def draw_whether_next_action_slips(self) -> bool:
        """Draw whether the next possible action slips, that is, has no effect."""
        return self._random.random() < self._probability


class Episode:
    """A world in which actions are tried one after the other, and the history of the states so far.

    An action changes nothing if it is impossible or slips (by chance has no effect). Then the next action is
    tried in the same state. A wrong order is diagnosed by a search through all earlier states of the
    episode. In a new episode without slips, `run` gives the same trajectory as `execute_plan`.

    Args:
        domain: the world.
        initial: the initial state. `Domain.begin` may add facts to it.
        slip_sampler: draws which possible actions slip; None for no slips.
        known_outcomes: cache of outcomes from the initial state on, to which the episode adds its outcomes.
    """

    def __init__(
        self,
        domain: Domain,
        initial: State,
        slip_sampler: SlipSampler | None = None,
        known_outcomes: KnownOutcomes | None = None,
    ) -> None:
        self.domain = domain
        self._slip_sampler = slip_sampler
        self._known_outcomes = {} if known_outcomes is None else known_outcomes
        self._simulator = domain.begin(initial)
        self._history = History(self._simulator.state)
        self._steps: list[Step] = []

    @property
    def state(self) -> State:
        """The current state."""
        return self._history.state

    @property
    def trajectory(self) -> Trajectory:
        """The states and steps of the episode so far."""
        return Trajectory(self._history.states, tuple(self._steps))

    def trajectory_from(self, start: int) -> Trajectory:
        """Return the trajectory without its first steps. Faults may still refer to states that are left out.

        Args:
            start: number of tried steps to leave out.
        """
        offset = sum([step.is_executed for step in self._steps[:start]])
        steps = [_lower_state_index_in_fault(step, offset) for step in self._steps[start:]]
        return Trajectory(self._history.states[offset:], tuple(steps))

    def act(self, action: Action) -> Outcome:
        """Try one action. It must name an operator, and have as many arguments as the operator takes."""
        known = self._known_outcomes.get(action)
        if known is None:
            known = self._known_outcomes[action] = (attempt_action(self.domain, self._history, action), {})
        declared, known_outcomes_after_action = known
        outcome = declared
        if isinstance(declared, State):
            if self._slip_sampler is not None and self._slip_sampler.draw_whether_next_action_slips():
                return self.append_slipped_step(action)
            outcome = self._simulator.act(action, declared)
        self._steps.append(Step(action, outcome if isinstance(outcome, Fault) else None))
        if isinstance(outcome, State):
            self._known_outcomes = known_outcomes_after_action if outcome is declared else {}
            self._history = self._history.extend(outcome)
        return outcome

    def append_slipped_step(self, action: Action) -> Slip:
        """Append a step in which an action slipped (had no effect). The state stays as it is."""
        self._steps.append(Step(action, None, slipped=True))
        return Slip()

    def run(
        self, plan: Iterable[Action], until: Callable[[Episode], bool] | None = None
    ) -> Fault | Slip | None:
        """Try the actions of a plan until its last action, a fault that ends it, or a slip that is noticed.

        A slip is a possible action that by chance has no effect.

        Args:
            plan: the actions.
            until: function called after each executed action; if it returns True, the remaining actions are
                not tried.

        Returns:
            The fault or slip that ended the plan, or None.
        """
        for action in plan:
            outcome = self.act(action)
            match outcome:
                case State():
                    if until is not None and until(self):
                        return None
                case Fault(kind) if kind is not FaultKind.ADDITIONAL_STEP:
                    return outcome
                case Slip() if self._slip_sampler is not None and self._slip_sampler.notice == "detected":
                    return outcome
        return None


def _lower_state_index_in_fault(step: Step, removed_states: int) -> Step:
    """Return a step whose `Fault.earlier` is lowered, because the trajectory lost its first states."""
    fault = step.fault
    if fault is None or fault.earlier is None or not removed_states:
        return step
    return step._replace(fault=replace(fault, earlier=fault.earlier - removed_states))
