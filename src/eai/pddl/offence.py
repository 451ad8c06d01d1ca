"""The ways in which PDDL text can be wrong, by name."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from eai.errors import ParseError


class Offence(str, Enum):
    """The offence of a piece of PDDL. The values are the wire strings."""

    UNBALANCED = "unbalanced_parenthesis"
    """A parenthesis without its partner."""
    MALFORMED = "malformed"
    """Balanced, but not PDDL: a connective with a wrong number of parts, a word where a list is due, ..."""
    UNSUPPORTED = "unsupported"
    """PDDL beyond the fragment of the two domains: ``either``, numbers, preferences."""
    CONDITION_IN_EFFECT = "condition_in_effect"
    """``or``, ``exists``, ``imply`` or a negated compound where an effect is due."""
    EFFECT_IN_CONDITION = "effect_in_condition"
    """``when`` where a condition is due."""
    UNKNOWN_PREDICATE = "unknown_predicate"
    WRONG_ARITY = "wrong_arity"
    WRONG_ARGUMENT_TYPE = "wrong_argument_type"
    """An argument whose declared type the predicate does not admit. Planners do not check this."""
    UNKNOWN_TYPE = "unknown_type"
    UNBOUND_VARIABLE = "unbound_variable"
    UNDECLARED_CONSTANT = "undeclared_constant"
    DUPLICATE = "duplicate"
    """The same name declared twice in one list of parameters, predicates, operators or objects."""

    @property
    def stops_planner(self) -> bool:
        """Whether a planner that follows the standard refuses a domain with this offence."""
        return self is not Offence.WRONG_ARGUMENT_TYPE

    @property
    def stops_reading(self) -> bool:
        """Whether a text with this offence has no value; the others are wrong names in a value."""
        return self in _UNREADABLE


_UNREADABLE = frozenset(
    {
        Offence.UNBALANCED,
        Offence.MALFORMED,
        Offence.UNSUPPORTED,
        Offence.CONDITION_IN_EFFECT,
        Offence.EFFECT_IN_CONDITION,
    }
)


@dataclass(frozen=True, slots=True)
class PddlFinding:
    """One offence.

    Attributes:
        offence: its kind.
        name: the name at fault (predicate, type, variable, constant), or the expectation that was not met.
        place: where it is, in words: the operator and its part.
    """

    offence: Offence
    name: str
    place: str


class PddlError(ParseError):
    """A PDDL text that cannot be read, with the kind of offence.

    Args:
        offence: its kind.
        line: the offending line, counted from 1.
        column: the offending column, counted from 1.
        expected: what could have stood there, in words.
    """

    def __init__(self, offence: Offence, line: int, column: int, expected: str) -> None:
        super().__init__(line, column, expected)
        self.offence = offence
