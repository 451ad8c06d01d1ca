"""What a suite is of: the ability that is asked for, and the protocol, which says what the numbers mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from functools import cache
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, ClassVar, TypeVar

from eai.data.entry_points import entry_points_of
from eai.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from pydantic_core.core_schema import CoreSchema


class Protocol(str, Enum):
    """A named, versioned set of rules for scoring.

    `STRICT` is what the paper says, with the defects of its reference package mended. `EAI_1_0_5` gives the
    verdicts of that package, release 1.0.5, defect by defect.
    """

    STRICT = "strict"
    EAI_1_0_5 = "eai-1.0.5"


_NAMED: dict[str, Ability] = {}
"""The one value of each name."""


class Ability(str):
    """The name of an ability: what records, files and options call it.

    There is one value for each name, so that abilities can be compared by identity. What one asks, and how
    answers to it are read, judged and counted, is registered under the name (`eai.abilities.declaration`).
    """

    __slots__ = ()

    GOAL_INTERPRETATION: ClassVar[Ability]
    SUBGOAL_DECOMPOSITION: ClassVar[Ability]
    ACTION_SEQUENCING: ClassVar[Ability]
    TRANSITION_MODELING: ClassVar[Ability]

    def __new__(cls, name: str) -> Ability:
        """The ability of this name, whether or not one is registered."""
        return _NAMED.setdefault(name, super().__new__(cls, name))

    @property
    def value(self) -> str:
        """The name as a plain text."""
        return str(self)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: object) -> CoreSchema:
        """Pydantic reads the name of a registered ability."""
        from pydantic_core import core_schema

        return core_schema.no_info_after_validator_function(_read, core_schema.str_schema())


Ability.GOAL_INTERPRETATION = Ability("goal_interpretation")
Ability.SUBGOAL_DECOMPOSITION = Ability("subgoal_decomposition")
Ability.ACTION_SEQUENCING = Ability("action_sequencing")
Ability.TRANSITION_MODELING = Ability("transition_modeling")

FOUR = (
    Ability.GOAL_INTERPRETATION,
    Ability.SUBGOAL_DECOMPOSITION,
    Ability.ACTION_SEQUENCING,
    Ability.TRANSITION_MODELING,
)
"""The paper's four abilities, in its order: what is asked for where no ability is named."""

GROUP = "eai.abilities"
"""The group of entry points by which a distribution registers an `AbilityDeclaration`."""

BUILT_IN = {
    **{ability.value: f"eai.abilities.{ability}.declaration:{ability.upper()}" for ability in FOUR},
    "world_model": "eai.questions.declaration:WORLD_MODEL",
}
"""The abilities that come with the package, as its metadata have them, too."""


@cache
def registered_abilities() -> Mapping[Ability, EntryPoint]:
    """All abilities: the paper's in its order, ours, then the others by name."""
    found = entry_points_of(GROUP, BUILT_IN)
    others = [name for name in sorted(found) if name not in BUILT_IN]
    return {Ability(name): found[name] for name in (*BUILT_IN, *others) if name in found}


E = TypeVar("E", bound=Enum)


def place_of(ability: Ability) -> int:
    """What abilities are sorted by; those that are not installed come last."""
    known = list(registered_abilities())
    return known.index(ability) if ability in known else len(known)


def ability_of(name: Ability | str) -> Ability:
    """The registered ability of this name.

    Raises:
        InputError: there is none.
    """
    ability = Ability(name)
    if ability not in registered_abilities():
        raise _unknown(name, "ability", registered_abilities())
    return ability


def _read(name: str) -> Ability:
    """The registered ability of this name, for pydantic."""
    from pydantic_core import PydanticCustomError

    if name not in registered_abilities():
        known = " or ".join(map(repr, map(str, registered_abilities())))
        raise PydanticCustomError("enum", "Input should be {expected}", {"expected": known})
    return Ability(name)


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
        raise _unknown(str(name), noun, [each.value for each in kind]) from error


def _unknown(name: str, noun: str, known: Iterable[str]) -> InputError:
    """The error that there is no such thing."""
    return InputError(f"{name!r} is no {noun}: expected one of {', '.join(known)}{did_you_mean(name, known)}")
