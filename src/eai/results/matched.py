"""Two rates on different tasks, compared where the tasks are alike.

Tasks are put into strata of what they are like. Those of the second set are weighted so that each stratum
weighs as much as in the first (post-stratification); strata that only one set has are left out of both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.share import Share
from eai.results.certainty import Case, Certainty, certainty_of_difference
from eai.results.rate import rate_of


class Placed(NamedTuple):
    """What one task contributes to a rate, and what it is like."""

    case: Case
    stratum: Hashable


@dataclass(frozen=True, slots=True)
class MatchedDifference:
    """The difference of two rates where the tasks are alike.

    Attributes:
        first: the rate in the first set, in percent.
        second: that in the second, weighted to the strata of the first.
        certainty: of second minus first, in percentage points; the names of both sets are its units. The gain
            from strata is not reckoned with, so that the interval is rather too wide.
        tasks: how many tasks of the first and of the second set are in a common stratum.
    """

    first: float
    second: float
    certainty: Certainty
    tasks: tuple[int, int]

    @property
    def difference(self) -> float:
        """Second minus first, in percentage points."""
        return self.second - self.first


def matched_difference(first: Sequence[Placed], second: Sequence[Placed]) -> MatchedDifference | None:
    """The difference of two rates where the tasks are alike; None if they never are."""
    sizes, others = (Counter(stratum for _, stratum in each) for each in (first, second))
    ones = [_apart(case, "first") for case, stratum in first if stratum in others]
    weighted = [
        _apart(case, "second", sizes[stratum] / others[stratum]) for case, stratum in second if sizes[stratum]
    ]
    certainty = certainty_of_difference(ones, weighted) if ones else None
    if certainty is None:
        return None
    return MatchedDifference(_percent(ones), _percent(weighted), certainty, (len(ones), len(weighted)))


def _apart(case: Case, which: str, weight: float = 1) -> Case:
    """A task that is none of the other set, with a weight."""
    share = Share(weight * case.share.numerator, weight * case.share.denominator)
    return Case(f"{which} {case.task}", f"{which} {case.name}", share)


def _percent(cases: Sequence[Case]) -> float:
    rate = rate_of(case.share for case in cases)
    return 0.0 if rate.percent is None else rate.percent
