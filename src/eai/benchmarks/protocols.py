"""Find protocols (rules for scoring) other than ``strict`` by name.

A distribution registers a protocol by an entry point of the group ``eai.protocols``. The entry point is a
`ProtocolImplementation`, which states all differences from ``strict``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from eai.abilities.protocol import find_protocols
from eai.base.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from eai.abilities.attempt_options import AttemptOptions
    from eai.abilities.protocol import Ability
    from eai.abilities.trial import Trial
    from eai.abilities.verdict import PlanVerdict, Verdict
    from eai.benchmarks.benchmark import Benchmark, Opener
    from eai.benchmarks.names import TaskReference


@dataclass(frozen=True, slots=True)
class ProtocolImplementation:
    """Differences of a protocol from ``strict``: how it scores answers, and how its published runs were made.

    Attributes:
        open_suite: opens a suite whose answers are read, tested and counted as the protocol says. Raises
            InputError for a benchmark that the protocol does not score.
        attempts: returns the options of the published script for several attempts at a task. Arguments are
            the probability and the seed of failing actions, and the number of attempts after the first (0 for
            the script's own number).
        trial: executes plans as the published script does.
        as_asked: returns the verdict by the goals that the prompts of published runs stated.
        as_counted: returns verdicts on attempts, with errors counted as in the published script, given the
            number of attempts after the first.
        adapt_to_answers: returns the opener of a suite that scores all answers of a model together; None if
            each answer is read without the others.
    """

    open_suite: Opener
    attempts: Callable[[float, int, int], AttemptOptions]
    trial: type[Trial]
    as_asked: Callable[[TaskReference, Verdict], Verdict]
    as_counted: Callable[[Sequence[PlanVerdict], int], Sequence[PlanVerdict]]
    adapt_to_answers: Callable[[Benchmark, Ability, Iterable[str]], Opener | None] | None = None


@cache
def find_implementation(name: str) -> ProtocolImplementation | None:
    """Return the registered implementation of a protocol, or None if no protocol has this name.

    Raises:
        InputError: the registered value is not a `ProtocolImplementation`.
    """
    if name not in find_protocols():
        return None
    value = find_protocols()[name].load()
    if not isinstance(value, ProtocolImplementation):
        raise InputError(f"{name}: expected a ProtocolImplementation, found {type(value).__name__}")
    return value


def find_preset(name: str) -> ProtocolImplementation:
    """Return the implementation of the protocol that a published script uses, by the name of the protocol.

    Raises:
        InputError: no protocol has this name.
    """
    implementation = find_implementation(name)
    if implementation is None:
        protocols = find_protocols()
        expected = f"expected {' or '.join(protocols)}" if protocols else "no protocol is registered"
        raise InputError(f"{name!r} is not a preset: {expected}{did_you_mean(name, protocols)}")
    return implementation


def make_preset_attempt_options(
    name: str, slip: float, slip_seed: int, replans: int
) -> AttemptOptions | None:
    """Return the options of a published script for several attempts at a task, or None for an empty name.

    Raises:
        InputError: no script has this name.
    """
    return find_preset(name).attempts(slip, slip_seed, replans) if name else None
