"""Episodes: one action after the other in a world that stays, where a possible action may slip."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TypeAlias

from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, attempt
from eai.world.fault import FaultKind, Notice
from eai.world.history import History
from eai.world.state import State


@dataclass(frozen=True, slots=True)
class Slip:
    """An action that was possible did not work: nothing has changed."""


Outcome: TypeAlias = State | Fault | Slip
"""The outcome of an action: the state after it, the diagnosis of its failure, or a slip."""


KnownOutcomes: TypeAlias = "dict[Action, tuple[State | Fault, KnownOutcomes]]"
"""The outcome of each action that was tried in a state, and what is known of the state after it.

Episodes that begin alike may share it: then a step is worked out once for all that took the same way there.
"""


class SlipSampler:
    """The draws for one task and epoch: one for each possible action, none for an impossible one.

    So two policies meet the same luck at the same executed step. Episodes that share it continue its draws
    (paper, appendix on replanning with stochastic actions).

    Args:
        probability: that a possible action slips, from 0 to 1, independently of all others.
        task_id: the task.
        seed: of the draws.
        epoch: which of several independent repetitions this is.
        notice: whether a slip is noticed.
    """

    def __init__(
        self, probability: float, task_id: str, *, seed: int = 0, epoch: int = 0, notice: Notice = "detected"
    ) -> None:
        self.notice = notice
        self._probability = probability
        stream = hashlib.sha256(f"{seed} {task_id} {epoch}".encode()).digest()
        self._random = random.Random(stream)  # noqa: S311 - chance, not secrets

    def slips(self) -> bool:
        """Whether the next possible action slips."""
        return self._random.random() < self._probability


class Episode:
    """A world in which one action after the other is tried, and what has happened in it so far.

    An action that is impossible or slips changes nothing, and the next one is tried in the same state. A
    wrong order looks back over the whole episode. A plan that runs in a new episode without slips becomes
    what `execute` makes of it.

    Args:
        domain: the world.
        initial: the state to begin in, as `Domain.begin` may complete it.
        luck: which possible actions slip; none if None.
        known: what other episodes of the domain found out from this state on; this one adds to it.
    """

    def __init__(
        self,
        domain: Domain,
        initial: State,
        slip_sampler: SlipSampler | None = None,
        known_outcomes: KnownOutcomes | None = None,
    ) -> None:
        self.domain = domain
        self._luck = slip_sampler
        self._known = {} if known_outcomes is None else known_outcomes
        self._simulator = domain.begin(initial)
        self._past = History(self._simulator.state)
        self._steps: list[Step] = []

    @property
    def state(self) -> State:
        """The state now."""
        return self._past.state

    @property
    def trajectory(self) -> Trajectory:
        """All that has happened so far."""
        return Trajectory(self._past.states, tuple(self._steps))

    def trajectory_from(self, start: int) -> Trajectory:
        """The steps from one on, as a trajectory of its own; what it lacks may be before that.

        Args:
            start: how many steps had been tried before.
        """
        offset = sum([step.executed for step in self._steps[:start]])
        steps = [_later(step, offset) for step in self._steps[start:]]
        return Trajectory(self._past.states[offset:], tuple(steps))

    def act(self, action: Action) -> Outcome:
        """Try one action; it must name an operator of the domain and have as many arguments."""
        known = self._known.get(action)
        if known is None:
            known = self._known[action] = (attempt(self.domain, self._past, action), {})
        tried, then = known
        if isinstance(tried, State):
            if self._luck is not None and self._luck.slips():
                return self.record_slip(action)
            declared, tried = tried, self._simulator.act(action, tried)
            if tried is not declared:
                then = {}
        if isinstance(tried, Fault):
            self._steps.append(Step(action, tried))
            return tried
        self._known = then
        self._past = self._past.extended(tried)
        self._steps.append(Step(action, None))
        return tried

    def record_slip(self, action: Action) -> Slip:
        """Let an action slip that was not tried: nothing changes."""
        self._steps.append(Step(action, None, slipped=True))
        return Slip()

    def run(
        self, plan: Iterable[Action], until: Callable[[Episode], bool] | None = None
    ) -> Fault | Slip | None:
        """Try the actions of a plan up to a fatal fault, a detected slip or its end.

        Args:
            plan: the actions.
            until: asked after each executed action; the plan ends early where it is true.

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
                case Slip() if self._luck is not None and self._luck.notice == "detected":
                    return outcome
        return None


def _later(step: Step, offset: int) -> Step:
    """A step of a trajectory that begins so many states later."""
    fault = step.fault
    if fault is None or fault.earlier is None or not offset:
        return step
    return step._replace(fault=replace(fault, earlier=fault.earlier - offset))
