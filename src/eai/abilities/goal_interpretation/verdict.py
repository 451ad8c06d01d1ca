"""The verdict on an interpretation of goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.verdict import ALL, NO_COUNTS, Confusion, Credit, Verdict, credit_parts
from eai.base.json_value import Json
from eai.world.fault import FaultKind


@dataclass(frozen=True, slots=True)
class GoalVerdict(Verdict):
    """The verdict on an interpretation of goals.

    Attributes:
        counts: goals found, invented and missed, by kind, and ``all`` together. What is ill-formed or names
            what does not exist is not among those invented (the reference counts a part of it).
        predicted: how many goals the answer states, those included that are not counted.
        ill_formed: how many of them lack a part.
        hallucinated: for each goal that names what does not exist, the first such name.
        unknown_predicates: the predicates that there are not.
        matched: the stated goals that are right, as texts, each as often as it counts.
        wrong: those that are wrong, likewise; the entries that lack a part come first, as they are written.
        missing: the conditions of the task that are not stated, as texts.
        aborts: whether the reference would end its whole run here.
    """

    counts: Mapping[str, Confusion] | None = None
    predicted: int = 0
    ill_formed: int = 0
    hallucinated: tuple[str, ...] = ()
    unknown_predicates: tuple[str, ...] = ()
    matched: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    aborts: bool = False

    @property
    def columns(self) -> Mapping[str, Json]:
        """How many goals it states, and how many of them cannot count."""
        hallucinated = len(self.hallucinated)
        return {"stated": self.predicted, "ill_formed": self.ill_formed, "hallucinated": hallucinated}

    def credit(self, at_start: Sequence[bool]) -> Credit | None:
        """By F1; goals that lack a part, or name what there is not, are wrong, and faults besides."""
        hallucinated = len(self.hallucinated)
        faults = +Counter({FaultKind.PARSING: self.ill_formed, FaultKind.HALLUCINATION: hallucinated})
        counts = (self.counts or {}).get(ALL, NO_COUNTS)
        return credit_parts(counts, self.error, faults, meaningless=hallucinated + self.ill_formed)
