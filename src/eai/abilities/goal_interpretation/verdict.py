"""The verdict on a goal interpretation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.verdict import ALL, NO_COUNTS, Confusion, Credit, Verdict, credit_parts
from eai.base.json_value import Json
from eai.world.fault import FaultKind


@dataclass(frozen=True, slots=True)
class GoalVerdict(Verdict):
    """The verdict on a goal interpretation.

    Attributes:
        counts: numbers of goals found, wrong and missed, by kind, and in total under ``all``. Ill-formed
            goals and goals with unknown names are not counted as wrong (the reference counts some of them).
        predicted: number of goals that the answer states, including goals that are not counted.
        ill_formed: number of ill-formed goals among them.
        hallucinated: for each goal with an unknown name, the first such name.
        unknown_predicates: predicates that do not exist.
        matched: right goals as texts, each as often as it counts.
        wrong: wrong goals as texts, each as often as it counts; entries that lack a part come first, as
            written.
        missing: conditions of the task that the answer does not state, as texts.
        aborts: whether the reference would end its whole run at this answer.
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
        """The values by column: the number of stated goals, and the numbers of goals that cannot count."""
        hallucinated = len(self.hallucinated)
        return {"stated": self.predicted, "ill_formed": self.ill_formed, "hallucinated": hallucinated}

    def credit(self, at_start: Sequence[bool]) -> Credit | None:
        """Return the credit by F1.

        Ill-formed goals and goals with unknown names count as wrong and as faults.
        """
        hallucinated = len(self.hallucinated)
        faults = +Counter({FaultKind.PARSING: self.ill_formed, FaultKind.HALLUCINATION: hallucinated})
        counts = (self.counts or {}).get(ALL, NO_COUNTS)
        return credit_parts(counts, self.error, faults, meaningless=hallucinated + self.ill_formed)
