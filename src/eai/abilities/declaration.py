"""What an ability declares, in one place: its verdict, what an answer adds to which metrics, its columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Generic, TypeVar

from eai.abilities.protocol import Ability
from eai.abilities.share import Shares
from eai.abilities.verdict import Confusion, PlanVerdict, Verdict
from eai.world.fault import FaultKind

V = TypeVar("V", bound=Verdict)


class AnswerOutcome(str, Enum):
    """What one answer, or the lack of one, came to; what is no error of the model's comes first."""

    EXCLUDED = "excluded"
    NOT_ANSWERED = "not_answered"
    SUCCESS = "success"
    PARTLY_RIGHT = "partly_right"
    """Goals or operators of which some are right."""
    GOAL_MISSED = "goal_missed"
    """The plan ran, or the goals or operators could be read, but nothing came of it."""
    PARSING = FaultKind.PARSING.value
    HALLUCINATION = FaultKind.HALLUCINATION.value
    ARGUMENT_NUMBER = FaultKind.ARGUMENT_NUMBER.value
    AFFORDANCE = FaultKind.AFFORDANCE.value
    MISSING_STEP = FaultKind.MISSING_STEP.value
    WRONG_ORDER = FaultKind.WRONG_ORDER.value
    ADDITIONAL_STEP = FaultKind.ADDITIONAL_STEP.value
    UNCATEGORISED = FaultKind.UNCATEGORISED.value
    SLIP = FaultKind.SLIP.value


@dataclass(frozen=True, slots=True)
class MetricColumn:
    """A column of the ability's tables.

    Attributes:
        metric: the name of the metric.
        group: the heading above it and its neighbours.
        label: its own heading.
        more_is_better: whether the largest number is the best, which then is printed in bold.
    """

    metric: str
    group: str
    label: str
    more_is_better: bool = True


def one_by_one(verdicts: Sequence[V]) -> Sequence[V]:
    """The verdicts of a run as they count: each as it is."""
    return verdicts


@dataclass(frozen=True, slots=True)
class AbilityDeclaration(Generic[V]):
    """One of the paper's abilities, as records, metrics and tables know it.

    Attributes:
        ability: which one.
        title: its name for readers.
        short: its name where there is little room.
        verdict: the class of its verdicts.
        contributions: what an answer adds to each metric; all verdicts have the same metrics in one order.
        outcome: what an answer that is not excluded came to.
        columns: the columns of its tables, from left to right.
        terminal: the metrics that a terminal shows.
        main: the metrics of the overview, the paper's among them, each with its heading there.
        averaged: the metrics whose mean is its part in the paper's average over all abilities.
        instead: by a metric of the paper, the one that ranks and is averaged in its place where it is known.
        yes_no: the metrics to which every answer contributes a yes or a no.
        of_run: the verdicts of one run as they count there.
    """

    ability: Ability
    title: str
    short: str
    verdict: type[V]
    contributions: Callable[[V], Shares]
    outcome: Callable[[V], AnswerOutcome]
    columns: tuple[MetricColumn, ...]
    terminal: tuple[str, ...]
    main: Mapping[str, str]
    averaged: tuple[str, ...]
    instead: Mapping[str, str] = field(default_factory=dict)
    yes_no: frozenset[str] = frozenset()
    of_run: Callable[[Sequence[V]], Sequence[V]] = field(default=one_by_one)

    @property
    def has_plans(self) -> bool:
        """Whether its answers are carried out."""
        return issubclass(self.verdict, PlanVerdict)


def error_outcome(verdict: Verdict) -> AnswerOutcome | None:
    """The error that ended an answer as an outcome, or None if none did."""
    return None if verdict.error is None else AnswerOutcome(verdict.error.kind.value)


def counts_outcome(counts: Confusion, *, enough: bool = True) -> AnswerOutcome:
    """What an answer came to whose parts are right or wrong; if all are right, whether that is enough."""
    if enough and not counts.false_positives and counts.false_negatives <= 0:
        return AnswerOutcome.SUCCESS
    return AnswerOutcome.PARTLY_RIGHT if counts.true_positives else AnswerOutcome.GOAL_MISSED


def label_of(name: str) -> str:
    """A metric, a kind of error or a category for readers."""
    return name.replace("_", " ").replace(".", " ").capitalize()


def score_columns(parts: Sequence[str]) -> tuple[MetricColumn, ...]:
    """Precision, recall and F1 of each part."""
    measures = (("precision", "P"), ("recall", "R"), ("f1", "F1"))
    return tuple(
        MetricColumn(f"{part}.{measure}", label_of(part), label)
        for part in parts
        for measure, label in measures
    )
