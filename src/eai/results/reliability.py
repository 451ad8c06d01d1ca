"""How far raters agree: the spread of their ratings of one thing, and Krippendorff's alpha."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean, pvariance
from typing import TypeAlias

Units: TypeAlias = Sequence[Sequence[float]]
"""For each thing that was rated, the ratings that it got, each by another rater."""


def mean_rating(units: Units) -> float | None:
    """The mean of all ratings; None if there are none."""
    ratings = [rating for unit in units for rating in unit]
    return fmean(ratings) if ratings else None


def weighted_mse(units: Units) -> float | None:
    """How far ratings of one thing lie from their mean, squared: the mean over things, weighted by ratings.

    Things that were rated once say nothing of it and are left out; None if there are no others.
    """
    repeated = [unit for unit in units if len(unit) > 1]
    number = sum(map(len, repeated))
    return sum(len(unit) * pvariance(unit) for unit in repeated) / number if number else None


def krippendorff_alpha(units: Units) -> float | None:
    """Krippendorff's alpha for ratings on an interval scale, any of which may be missing.

    1 is perfect agreement, 0 what chance gives if raters draw from all ratings, below 0 worse than that.
    (K. Krippendorff, Content Analysis, chapter "Reliability": observed by expected squared differences.)

    Returns:
        None if no thing was rated twice, or all those ratings are the same.
    """
    pairable = [unit for unit in units if len(unit) > 1]
    ratings = [rating for unit in pairable for rating in unit]
    if not ratings or len(set(ratings)) == 1:
        return None
    number = len(ratings)
    # The squares of a unit's ordered pairs add up to 2 size^2 variances; each rating is in size - 1 pairs.
    observed = sum(2 * len(unit) ** 2 * pvariance(unit) / (len(unit) - 1) for unit in pairable) / number
    expected = 2 * number * pvariance(ratings) / (number - 1)
    return 1 - observed / expected
