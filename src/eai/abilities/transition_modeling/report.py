"""What comparing an answer's operators with the gold ones found out, operator by operator."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from eai.pddl.match import NO_MATCH, SideMatch
from eai.pddl.offence import PddlFinding


class OperatorStatus(str, Enum):
    """What became of one operator."""

    COMPARED = "compared"
    MISSING = "missing"
    """Asked for, and not in the answer."""
    UNREADABLE = "unreadable"
    """In the answer, but its text is not PDDL."""
    HALLUCINATED = "hallucinated"
    """In the answer, and not asked for."""


@dataclass(frozen=True, slots=True)
class OperatorReport:
    """One operator that is asked for or written.

    Attributes:
        precondition: clauses matched, additional and missing in the precondition; or predicates, if the
            rules count those.
        effect: the same for the effect.
        offences: what is wrong with it, whatever the gold operator.
    """

    name: str
    status: OperatorStatus
    precondition: SideMatch = NO_MATCH
    effect: SideMatch = NO_MATCH
    offences: tuple[PddlFinding, ...] = ()
