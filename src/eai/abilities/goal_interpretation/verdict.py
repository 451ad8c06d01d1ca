"""The verdict on a goal interpretation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.verdict import (
    ALL,
    NO_COUNTS,
    ConfusionCounts,
    RewardInputs,
    Verdict,
    compute_reward_inputs_from_part_counts,
    sum_confusion_counts,
)
from eai.base.json_value import Json
from eai.world.fault import FaultKind


@dataclass(frozen=True, slots=True)
class GoalVerdict(Verdict):
    """The verdict on a goal interpretation.

    Attributes:
        counts: numbers of right, wrong and missed goals, by kind, and in total under ``all``. Ill-formed
            goals and goals with unknown names do not count as wrong (the paper's package counts some of
            them).
        predicted: number of goals that the answer states, including goals that are not counted.
        ill_formed: number of ill-formed goals in the answer.
        hallucinated: for each goal with an unknown name, the first unknown name.
        unknown_predicates: predicates in the answer that do not exist.
        matched: right goals as texts, each as often as it counts.
        wrong: wrong goals as texts, each as often as it counts. Incomplete entries come first, as the answer
            states them.
        missing: conditions of the task that the answer does not state, as texts.
        aborts: whether the paper's package would end its run with an exception at this answer.
    """

    counts: Mapping[str, ConfusionCounts] | None = None
    predicted: int = 0
    ill_formed: int = 0
    hallucinated: tuple[str, ...] = ()
    unknown_predicates: tuple[str, ...] = ()
    matched: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    aborts: bool = False

    @property
    def success(self) -> bool | None:
        """Whether the answer states all goals of the task and no other goal; None if the task is excluded."""
        if self.excluded is not None:
            return None
        counts = sum_confusion_counts((self.counts or {}).values())
        is_flawless = not (self.error or self.ill_formed or self.hallucinated or counts.false_positives)
        return is_flawless and counts.false_negatives <= 0

    @property
    def values_by_column(self) -> Mapping[str, Json]:
        """Numbers of stated, ill-formed and hallucinated goals, by table column."""
        hallucinated = len(self.hallucinated)
        return {"stated": self.predicted, "ill_formed": self.ill_formed, "hallucinated": hallucinated}

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the inputs of the reward, or None if the task has no goals.

        The gain (`RewardInputs.gain`) is F1 of the goals in the answer. Ill-formed goals and goals with
        unknown names count as wrong goals, and are also listed as faults.
        """
        hallucinated = len(self.hallucinated)
        faults = +Counter({FaultKind.PARSING: self.ill_formed, FaultKind.HALLUCINATION: hallucinated})
        counts = (self.counts or {}).get(ALL, NO_COUNTS)
        return compute_reward_inputs_from_part_counts(
            counts, self.error, faults, ill_formed_or_unknown_parts=hallucinated + self.ill_formed
        )
