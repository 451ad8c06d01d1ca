"""What comparing an answer's operators with the gold ones found out, operator by operator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import Confusion, Json
from eai.pddl.matching import NO_MATCH, SideMatch
from eai.pddl.offence import PddlFinding

OTHER = "other"
"""The category of predicates that the domain does not have."""


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
        precondition: predicates matched, additional and missing in the precondition.
        effect: the same for the effect.
        findings: what is wrong with it, whatever the gold operator.
    """

    name: str
    status: OperatorStatus
    precondition: SideMatch = NO_MATCH
    effect: SideMatch = NO_MATCH
    findings: tuple[PddlFinding, ...] = ()

    def to_json(self) -> Json:
        """The report as it stands in a record."""
        return {
            "name": self.name,
            "status": self.status.value,
            "precondition": _side_json(self.precondition),
            "effect": _side_json(self.effect),
            "offences": [
                {"offence": finding.offence.value, "name": finding.name, "place": finding.place}
                for finding in self.findings
            ],
        }


def _side_json(side: SideMatch) -> Json:
    return {
        "matched": list(side.matched),
        "additional": list(side.additional),
        "missing": list(side.missing),
    }


def count_by_category(
    sides: Iterable[SideMatch], categories: Mapping[str, Category], *, count_others: bool
) -> dict[str, Confusion]:
    """Matched, additional and missing predicates by category; categories without any are left out.

    Args:
        sides: preconditions, or effects.
        categories: predicate -> category.
        count_others: whether predicates without a category count, as `OTHER`.
    """
    counts: dict[Category | None, list[int]] = {}
    for side in sides:
        for index, names in enumerate((side.matched, side.additional, side.missing)):
            for name in names:
                category = categories.get(name)
                if category is not None or count_others:
                    counts.setdefault(category, [0, 0, 0])[index] += 1
    named = {OTHER if category is None else category.value: found for category, found in counts.items()}
    return {name: Confusion(*named[name]) for name in sorted(named)}
