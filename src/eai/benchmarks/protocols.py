"""Find protocols other than ``strict`` by name. Each protocol is one value.

A distribution registers a protocol by an entry point of the group ``eai.protocols``: an `Implementation`.
All differences of a protocol are in that value.
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
class Implementation:
    """How a protocol scores answers, and how its published runs were made and counted.

    Attributes:
        open_suite: opens a suite with the protocol's readers, goal tests and counters. Raises InputError for
            a benchmark that the protocol does not score.
        attempts: returns the options of attempts in the published script, given the probability and the seed
            of failing actions, and the number of further attempts (0 for the script's number).
        trial: executes plans as the published script does.
        as_asked: returns the verdict on a task by the goals in the prompts of published runs.
        as_counted: returns the verdicts on attempts with errors counted as in the published script, given the
            number of further attempts.
        over: returns the opener of a suite whose answers are scored together; None if each is read alone.
    """

    open_suite: Opener
    attempts: Callable[[float, int, int], AttemptOptions]
    trial: type[Trial]
    as_asked: Callable[[TaskReference, Verdict], Verdict]
    as_counted: Callable[[Sequence[PlanVerdict], int], Sequence[PlanVerdict]]
    adapt_to_answers: Callable[[Benchmark, Ability, Iterable[str]], Opener | None] | None = None


@cache
def find_implementation(name: str) -> Implementation | None:
    """Return the implementation of a protocol, or None if the name is not registered.

    Raises:
        InputError: the registered value is not an `Implementation`.
    """
    if name not in find_protocols():
        return None
    value = find_protocols()[name].load()
    if not isinstance(value, Implementation):
        raise InputError(f"{name}: expected an Implementation, found {type(value).__name__}")
    return value


def find_preset(name: str) -> Implementation:
    """Return the protocol of a published script, by name.

    Raises:
        InputError: there is no such protocol.
    """
    implementation = find_implementation(name)
    if implementation is None:
        protocols = find_protocols()
        expected = f"expected {' or '.join(protocols)}" if protocols else "no protocol is registered"
        raise InputError(f"{name!r} is not a preset: {expected}{did_you_mean(name, protocols)}")
    return implementation


def preset_attempts(name: str, slip: float, slip_seed: int, replans: int) -> AttemptOptions | None:
    """Return the attempts at a task of a published script, or None if its name is empty.

    Raises:
        InputError: there is no such script.
    """
    return find_preset(name).attempts(slip, slip_seed, replans) if name else None
