"""Protocols other than ``strict``: each is one value, found by name.

A distribution registers one by an entry point of the group ``eai.protocols``, an `Implementation`. Nothing
else knows of it: what a protocol does otherwise is in that value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING

from eai.data.entry_points import entry_points_of
from eai.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from eai.abilities.action_sequencing.trial import Trial
    from eai.abilities.experiment import Experiment
    from eai.abilities.record import Record
    from eai.benchmark.benchmark import Opener

GROUP = "eai.protocols"
"""The group of entry points."""

BUILT_IN = {"eai-1.0.5": "eai.reference.protocol:EAI_1_0_5"}
"""The protocols that come with the package, as its metadata have them, too."""


@dataclass(frozen=True, slots=True)
class Implementation:
    """How a protocol scores answers, and how the runs that were published under it were made and counted.

    Attributes:
        open_suite: opens a suite with the protocol's readers, goal tests and counters; InputError where it
            does not score the benchmark.
        experiment: the experiment of its published script, with which probability and seed actions fail,
            and with how many further attempts (the script's number if 0).
        trial: how that script carries out plans.
        as_asked: a record as it counts by the goals that the published runs were asked for.
        as_counted: the record of an experiment with its errors counted as that script did.
    """

    open_suite: Opener
    experiment: Callable[[float, int, int], Experiment]
    trial: type[Trial]
    as_asked: Callable[[Record], Record]
    as_counted: Callable[[Record], Record]


@cache
def _found() -> Mapping[str, EntryPoint]:
    return entry_points_of(GROUP, BUILT_IN)


def implemented() -> tuple[str, ...]:
    """The names of all protocols that are implemented besides ``strict``."""
    return tuple(sorted(_found()))


@cache
def implementation_of(name: str) -> Implementation | None:
    """The implementation of a protocol; None if there is none.

    Raises:
        InputError: what is registered is none.
    """
    if name not in _found():
        return None
    value = _found()[name].load()
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
        known = implemented()
        expected = f"expected {' or '.join(known)}" if known else "there is none"
        raise InputError(f"{name!r} is no preset: {expected}{did_you_mean(name, known)}")
    return implementation


def preset_experiment(name: str, slip: float, slip_seed: int, replans: int) -> Experiment | None:
    """The experiment of a preset; None if it has no name.

    Raises:
        InputError: there is no such preset.
    """
    return preset(name).experiment(slip, slip_seed, replans) if name else None
