"""Find protocols (rules for scoring) other than ``strict`` by name.

A distribution registers a protocol by an entry point of the group ``eai.protocols``. The entry point is a
`ProtocolImplementation`, which states all differences from ``strict``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from eai.abilities.protocol import find_protocol_entry_points
from eai.base.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from eai.abilities.protocol import Ability
    from eai.abilities.replanning_options import ReplanningOptions
    from eai.abilities.trial import MultiAttemptTrial
    from eai.abilities.verdict import PlanVerdict, Verdict
    from eai.benchmarks.benchmark import Benchmark, Opener
    from eai.benchmarks.names import TaskReference


@dataclass(frozen=True, slots=True)
class ProtocolImplementation:
    """A protocol (rules for scoring) as its differences from the protocol ``strict``, the paper's text.

    Attributes:
        open_suite: returns scorers that read, test and count answers by the rules of the protocol. Raises
            InputError for a benchmark that the protocol does not score.
        replanning: returns the options with which the paper's published program asks for further plans after
            a failed plan. Arguments: the probability that an action fails at random, the seed of these
            failures, and the number of further plans (0 for that program's own number).
        trial: executes the plans for one task as that program does.
        judge_by_goals_in_prompt: returns the verdict on an answer, given the goals that its prompt stated in
            published runs.
        count_errors_as_published: returns the verdicts on all plans for one task, with errors counted as in
            that program. Its arguments are the verdicts and the maximum number of plans after the first.
        choose_suite_for_answers: given all answers of a model, returns a function that replaces `open_suite`,
            or None for no change. The attribute is None if other answers do not influence how an answer is
            read.
    """

    open_suite: Opener
    replanning: Callable[[float, int, int], ReplanningOptions]
    trial: type[MultiAttemptTrial]
    judge_by_goals_in_prompt: Callable[[TaskReference, Verdict], Verdict]
    count_errors_as_published: Callable[[Sequence[PlanVerdict], int], Sequence[PlanVerdict]]
    choose_suite_for_answers: Callable[[Benchmark, Ability, Iterable[str]], Opener | None] | None = None


@cache
def find_implementation(name: str) -> ProtocolImplementation | None:
    """Return the registered implementation of a protocol (rules for scoring), or None for an unknown name.

    Raises:
        InputError: the registered value is not a `ProtocolImplementation`.
    """
    if name not in find_protocol_entry_points():
        return None
    value = find_protocol_entry_points()[name].load()
    if not isinstance(value, ProtocolImplementation):
        raise InputError(f"{name}: expected a ProtocolImplementation, found {type(value).__name__}")
    return value


def require_protocol_implementation(name: str) -> ProtocolImplementation:
    """Return the implementation of the named protocol: the scoring rules of a published script.

    Raises:
        InputError: no protocol has this name.
    """
    implementation = find_implementation(name)
    if implementation is None:
        protocols = find_protocol_entry_points()
        expected = f"expected {' or '.join(protocols)}" if protocols else "no protocol is registered"
        raise InputError(f"{name!r} is not a preset: {expected}{did_you_mean(name, protocols)}")
    return implementation


def make_replanning_options_of_protocol(
    protocol: str, slip_probability: float, slip_seed: int, replans: int
) -> ReplanningOptions | None:
    """Return the options of a published script for replanning after failures; None for an empty name.

    Raises:
        InputError: no script has this name.
    """
    if protocol:
        return require_protocol_implementation(protocol).replanning(slip_probability, slip_seed, replans)
    return None
