"""The two names of a suite: the ability that is asked for, and the protocol, which says what numbers mean."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar, cast

from typing_extensions import Self

from eai.base.entry_points import EntryPoint, get_entry_point_names, get_entry_points, has_module
from eai.base.errors import unknown_name_error

if TYPE_CHECKING:
    from pydantic_core.core_schema import CoreSchema


_NAMED: dict[tuple[type[_Name], str], _Name] = {}
"""The one value of each name."""


class _Name(str):
    """The name of what is registered: what records, files and options call it.

    There is one value for each name, so that names can be compared by identity.
    """

    __slots__ = ()

    def __new__(cls, name: str) -> Self:
        """This name, whether or not anything is registered under it."""
        found = _NAMED.setdefault((cls, name), super().__new__(cls, name))
        return cast(Self, found)

    @property
    def value(self) -> str:
        """The name as a plain text."""
        return str(self)

    @classmethod
    def known(cls) -> Collection[Self]:
        """The names that are known."""
        raise NotImplementedError

    @classmethod
    def named(cls, name: str) -> Self:
        """A known name.

        Raises:
            InputError: it is not known.
        """
        if name not in cls.known():
            raise unknown_name_error(name, cls.__name__.lower(), cls.known())
        return cls(name)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: object) -> CoreSchema:
        """Pydantic reads a known name."""
        from pydantic_core import PydanticCustomError, core_schema

        @cache
        def read(name: str) -> _Name:
            if name not in cls.known():
                known = " or ".join(map(repr, map(str, cls.known())))
                raise PydanticCustomError("enum", "Input should be {expected}", {"expected": known})
            return cls(name)

        return core_schema.no_info_after_validator_function(read, core_schema.str_schema())


class Protocol(_Name):
    """The name of a named, versioned set of rules for scoring.

    `STRICT` is what the paper says, with the defects of its reference package mended. The others are found by
    entry points of the group ``eai.protocols`` (`eai.benchmarks.protocols`): ``eai-1.0.5`` gives the verdicts
    of that package, release 1.0.5, defect by defect.
    """

    __slots__ = ()

    STRICT: ClassVar[Protocol]

    @classmethod
    def known(cls) -> Collection[Protocol]:
        """Return `STRICT` and then all registered protocols by name, also if their modules are absent."""
        return dict.fromkeys((cls.STRICT, *map(cls, get_entry_point_names(PROTOCOLS))))


Protocol.STRICT = Protocol("strict")

DEFAULT_PROTOCOL = Protocol.STRICT
"""The rules for scoring where nothing else is asked for."""

PROTOCOLS = "eai.protocols"
"""The group of entry points of protocols other than ``strict``."""


@cache
def registered_protocols() -> Mapping[str, EntryPoint]:
    """Return the installed protocols other than ``strict``, by name."""
    return get_entry_points(PROTOCOLS)


class Ability(_Name):
    """The name of an ability.

    What one asks, and how answers to it are read, judged and counted, is registered under the name
    (`eai.abilities.declaration`).
    """

    __slots__ = ()

    GOAL_INTERPRETATION: ClassVar[Ability]
    SUBGOAL_DECOMPOSITION: ClassVar[Ability]
    ACTION_SEQUENCING: ClassVar[Ability]
    TRANSITION_MODELING: ClassVar[Ability]

    @classmethod
    def known(cls) -> Collection[Ability]:
        """Return all registered abilities, also if their modules are absent; the paper's come first."""
        return dict.fromkeys(map(cls, get_entry_point_names(GROUP, _FIRST)))


Ability.GOAL_INTERPRETATION = Ability("goal_interpretation")
Ability.SUBGOAL_DECOMPOSITION = Ability("subgoal_decomposition")
Ability.ACTION_SEQUENCING = Ability("action_sequencing")
Ability.TRANSITION_MODELING = Ability("transition_modeling")

_PAPER = (
    Ability.GOAL_INTERPRETATION,
    Ability.SUBGOAL_DECOMPOSITION,
    Ability.ACTION_SEQUENCING,
    Ability.TRANSITION_MODELING,
)

FOUR = tuple([ability for ability in _PAPER if has_module(f"eai.abilities.{ability}.declaration")])
"""The paper's four abilities in its order, without those whose folders are absent. Default of commands."""

SCENE_GRAPH = Ability("scene_graph")
"""The ability that lists what is in pictures."""

GROUP = "eai.abilities"
"""The group of entry points by which a distribution registers an `AbilityDeclaration`."""

_FIRST = (*_PAPER, "world_model", "scene_graph", "acting")
"""Abilities that are listed first, in this order."""


@cache
def registered_abilities() -> Mapping[Ability, EntryPoint]:
    """Return the installed abilities, the paper's first."""
    return {Ability(name): point for name, point in get_entry_points(GROUP, _FIRST).items()}


def place_of(ability: Ability) -> int:
    """The place of an ability among all, by which they are sorted; those that are not installed come last."""
    known = list(registered_abilities())
    return known.index(ability) if ability in known else len(known)
