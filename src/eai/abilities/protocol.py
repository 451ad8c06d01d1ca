"""What a suite is of: the ability that is asked for, and the protocol, which says what the numbers mean."""

from __future__ import annotations

from enum import Enum
from typing import TypeVar

from eai.errors import InputError, did_you_mean


class Protocol(str, Enum):
    """A named, versioned set of rules for scoring.

    `STRICT` is what the paper says, with the defects of its reference package mended. `EAI_1_0_5` gives the
    verdicts of that package, release 1.0.5, defect by defect.
    """

    STRICT = "strict"
    EAI_1_0_5 = "eai-1.0.5"


class Ability(str, Enum):
    """The paper's four abilities."""

    GOAL_INTERPRETATION = "goal_interpretation"
    SUBGOAL_DECOMPOSITION = "subgoal_decomposition"
    ACTION_SEQUENCING = "action_sequencing"
    TRANSITION_MODELING = "transition_modeling"


E = TypeVar("E", bound=Enum)


def ability_of(name: Ability | str) -> Ability:
    """The ability of this name.

    Raises:
        InputError: there is none.
    """
    return member(Ability, name, "ability")


def protocol_of(name: Protocol | str) -> Protocol:
    """The protocol of this name.

    Raises:
        InputError: there is none.
    """
    return member(Protocol, name, "protocol")


def member(kind: type[E], name: E | str, noun: str) -> E:
    """The member of an enumeration with this value; ``noun`` is what a message calls such a thing.

    Raises:
        InputError: there is none.
    """
    try:
        return kind(name)
    except ValueError as error:
        known = [each.value for each in kind]
        hint = did_you_mean(str(name), known)
        raise InputError(f"{name!r} is no {noun}: expected one of {', '.join(known)}{hint}") from error
