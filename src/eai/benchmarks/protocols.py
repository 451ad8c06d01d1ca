"""Protocols other than ``strict``: each is one value, found by name.

A distribution registers one by an entry point of the group ``eai.protocols``, an `Implementation`. Nothing
else knows of it: what a protocol does otherwise is in that value.
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
    """How a protocol scores answers, and how the runs that were published under it were made and counted.

    Attributes:
        open_suite: opens a suite with the protocol's readers, goal tests and counters; InputError where it
            does not score the benchmark.
        attempts: returns the options of attempts in its published script, given the probability and the seed
            with which actions fail, and the number of further attempts (the script's number if 0).
        trial: how that script carries out plans.
        as_asked: returns the verdict on a task by the goals that the prompts of published runs stated.
        as_counted: returns the verdicts on the attempts of an experiment with errors counted as that script
            did, given the number of further attempts.
        over: what opens a suite for answers that are scored together; None where each is read by itself.
    """

    open_suite: Opener
    attempts: Callable[[float, int, int], AttemptOptions]
    trial: type[Trial]
    as_asked: Callable[[TaskReference, Verdict], Verdict]
    as_counted: Callable[[Sequence[PlanVerdict], int], Sequence[PlanVerdict]]
    over: Callable[[Benchmark, Ability, Iterable[str]], Opener | None] | None = None


@cache
def implementation_of(name: str) -> Implementation | None:
    """The implementation of a protocol; None if there is none.

    Raises:
        InputError: what is registered is none.
    """
    if name not in find_protocols():
        return None
    value = find_protocols()[name].load()
    if not isinstance(value, Implementation):
        raise InputError(f"{name}: expected an Implementation, found {type(value).__name__}")
    return value


def preset(name: str) -> Implementation:
    """The protocol whose published script is followed.

    Raises:
        InputError: there is no such protocol.
    """
    implementation = implementation_of(name)
    if implementation is None:
        known = find_protocols()
        expected = f"expected {' or '.join(known)}" if known else "there is none"
        raise InputError(f"{name!r} is no preset: {expected}{did_you_mean(name, known)}")
    return implementation


def preset_attempts(name: str, slip: float, slip_seed: int, replans: int) -> AttemptOptions | None:
    """Return the attempts at a task in a preset, or None if the name is empty.

    Raises:
        InputError: there is no such preset.
    """
    return preset(name).attempts(slip, slip_seed, replans) if name else None
