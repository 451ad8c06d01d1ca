"""The names of abilities and of protocols (versioned rules for scoring).

A suite is the set of a benchmark's questions for one ability, scored by one protocol.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar, cast

from typing_extensions import Self

from eai.base.entry_points import EntryPoint, get_entry_point_names, get_entry_points, has_module
from eai.base.errors import make_unknown_name_error

if TYPE_CHECKING:
    from pydantic_core.core_schema import CoreSchema


_NAME_CACHE: dict[tuple[type[_InternedAbilityOrProtocolName], str], _InternedAbilityOrProtocolName] = {}
"""Cache of name objects, so that equal names are the same object."""


class _InternedAbilityOrProtocolName(str):
    """The name of a registered ability (kind of question) or protocol (rules for scoring).

    There is only one object for each name, so that programs can compare names by identity.
    """

    __slots__ = ()

    def __new__(cls, name: str) -> Self:
        """Return the only object for a name. The name need not be registered."""
        value = _NAME_CACHE.setdefault((cls, name), super().__new__(cls, name))
        return cast(Self, value)

    @property
    def value(self) -> str:
        """The name as a plain text."""
        return str(self)

    @classmethod
    def list_names(cls) -> Collection[Self]:
        """Return all registered names: of abilities (kinds of questions) or protocols (rules for scoring)."""
        raise NotImplementedError

    @classmethod
    def from_name(cls, name: str) -> Self:
        """Return the registered ability (kind of question) or protocol (rules for scoring) of the given name.

        Raises:
            InputError: the name is not registered.
        """
        if name not in cls.list_names():
            raise make_unknown_name_error(name, cls.__name__.lower(), cls.list_names())
        return cls(name)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: object) -> CoreSchema:
        """Return the schema by which pydantic reads a registered name."""
        from pydantic_core import PydanticCustomError, core_schema

        @cache
        def validate_registered_name(name: str) -> _InternedAbilityOrProtocolName:
            if name not in cls.list_names():
                names = " or ".join(map(repr, map(str, cls.list_names())))
                raise PydanticCustomError(
                    "unknown_ability_or_protocol", "Input should be {expected}", {"expected": names}
                )
            return cls(name)

        return core_schema.no_info_after_validator_function(
            validate_registered_name, core_schema.str_schema()
        )


class Protocol(_InternedAbilityOrProtocolName):
    """The name of a protocol: a versioned set of rules for scoring.

    `STRICT` follows the paper and corrects the defects of its reference package. Other protocols are
    registered by entry points of the group ``eai.protocols`` (`eai.benchmarks.protocols`). ``eai-1.0.5``
    reproduces the verdicts of the reference package, release 1.0.5, with its defects.
    """

    __slots__ = ()

    STRICT: ClassVar[Protocol]

    @classmethod
    def list_names(cls) -> Collection[Protocol]:
        """Return the names of all protocols (rules for scoring), in alphabetical order after `STRICT`.

        A protocol is listed even if its module is missing.
        """
        return dict.fromkeys((cls.STRICT, *map(cls, get_entry_point_names(PROTOCOL_GROUP))))


Protocol.STRICT = Protocol("strict")

DEFAULT_PROTOCOL = Protocol.STRICT
"""Rules by which answers are scored if the user chooses no other rules."""

PROTOCOL_GROUP = "eai.protocols"
"""Group of the entry points that register protocols (rules for scoring) other than ``strict``."""


@cache
def find_protocol_entry_points() -> Mapping[str, EntryPoint]:
    """Return a mapping from names of protocols to entry points, without the built-in ``strict``."""
    return get_entry_points(PROTOCOL_GROUP)


class Ability(_InternedAbilityOrProtocolName):
    """The name of an ability: a kind of question, such as action sequencing.

    An `AbilityDeclaration` (`eai.abilities.declaration`) is registered under this name. It contains the
    question, the scorer and the metrics of the ability.
    """

    __slots__ = ()

    GOAL_INTERPRETATION: ClassVar[Ability]
    SUBGOAL_DECOMPOSITION: ClassVar[Ability]
    ACTION_SEQUENCING: ClassVar[Ability]
    TRANSITION_MODELING: ClassVar[Ability]

    @classmethod
    def list_names(cls) -> Collection[Ability]:
        """Return the names of all abilities (kinds of questions); the paper's abilities come first.

        An ability is listed even if its module is missing.
        """
        return dict.fromkeys(map(cls, get_entry_point_names(ABILITY_GROUP, _ABILITIES_LISTED_FIRST)))


Ability.GOAL_INTERPRETATION = Ability("goal_interpretation")
Ability.SUBGOAL_DECOMPOSITION = Ability("subgoal_decomposition")
Ability.ACTION_SEQUENCING = Ability("action_sequencing")
Ability.TRANSITION_MODELING = Ability("transition_modeling")

_ALL_PAPER_ABILITIES = (
    Ability.GOAL_INTERPRETATION,
    Ability.SUBGOAL_DECOMPOSITION,
    Ability.ACTION_SEQUENCING,
    Ability.TRANSITION_MODELING,
)

PAPER_ABILITIES = tuple(
    [ability for ability in _ALL_PAPER_ABILITIES if has_module(f"eai.abilities.{ability}.declaration")]
)
"""The installed abilities (kinds of questions) among the paper's four, in the paper's order.

Commands use these abilities by default.
"""

SCENE_GRAPH = Ability("scene_graph")
"""The kind of question for which models list the objects and facts that they see in pictures."""

ABILITY_GROUP = "eai.abilities"
"""Group of the entry points by which a distribution registers an `AbilityDeclaration`."""

_ABILITIES_LISTED_FIRST = (*_ALL_PAPER_ABILITIES, "world_model", "scene_graph", "acting")
"""The abilities (kinds of questions) that are listed before all others, in this order."""


@cache
def find_ability_entry_points() -> Mapping[Ability, EntryPoint]:
    """Return a mapping from installed abilities (kinds of questions) to entry points, the paper's first."""
    return {
        Ability(name): point
        for name, point in get_entry_points(ABILITY_GROUP, _ABILITIES_LISTED_FIRST).items()
    }


def get_ability_sort_key(ability: Ability) -> int:
    """Return the position, from 0, at which an ability stands in sorted lists of abilities.

    Abilities that are not installed come last.
    """
    abilities = list(find_ability_entry_points())
    return abilities.index(ability) if ability in abilities else len(abilities)
