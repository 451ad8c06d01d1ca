"""Synthetic runs with near copies of tasks, with the group sizes and the correlation of VirtualHome."""

from __future__ import annotations

import random
from collections.abc import Sequence

from eai.results.certainty import TaskRateContribution
from eai.tasks.share import Share

SIZES = (35, 33, 31, 26, 23, 23, 22, 22, 21, 19, 13, 11, 10, 7, 6, 6, 5, 5, 5, 4, 4, 3, 3, 2, 2, 1)
"""Number of tasks of each of the 26 names."""

ALIKE = 0.6
"""Intraclass correlation of success within names, measured in action sequencing."""


def chances(generator: random.Random, rate: float, alike: float, names: int) -> list[float]:
    """Return the chance of success of each name, with mean `rate`."""
    if not alike:
        return [rate] * names
    sureness = (1 - alike) / alike
    return [generator.betavariate(rate * sureness, (1 - rate) * sureness) for _ in range(names)]


def successes(
    generator: random.Random, rate: float, sizes: Sequence[int] = SIZES, alike: float = ALIKE
) -> list[TaskRateContribution]:
    """Return a yes or a no from each task."""
    return [
        TaskRateContribution(f"{case.name}_{copy}", case.name, Share(int(copy < case.share.numerator), 1))
        for case in successes_by_name(generator, rate, sizes, alike)
        for copy in range(int(case.share.denominator))
    ]


def successes_by_name(
    generator: random.Random, rate: float, sizes: Sequence[int] = SIZES, alike: float = ALIKE
) -> list[TaskRateContribution]:
    """Return one case for each name, from which intervals by name are computed."""
    draw = generator.random
    return [
        TaskRateContribution(str(name), str(name), Share(sum(draw() < chance for _ in range(size)), size))
        for name, (size, chance) in enumerate(
            zip(sizes, chances(generator, rate, alike, len(sizes)), strict=True)
        )
    ]


def matches(
    generator: random.Random, rate: float, sizes: Sequence[int] = SIZES, alike: float = ALIKE
) -> list[TaskRateContribution]:
    """Return the F1 share of each task: each of one to six goals is matched, or else replaced by a wrong one
    half of the time.

    Its expectation is `expected_f1`.
    """
    cases = []
    for name, (size, chance) in enumerate(
        zip(sizes, chances(generator, rate, alike, len(sizes)), strict=True)
    ):
        for copy in range(size):
            goals = generator.randint(1, 6)
            draws = [generator.random() for _ in range(goals)]
            hits = sum(draw < chance for draw in draws)
            invented = sum(draw > (1 + chance) / 2 for draw in draws)
            cases.append(
                TaskRateContribution(f"{name}_{copy}", str(name), Share(2 * hits, goals + hits + invented))
            )
    return cases


def expected_f1(rate: float) -> float:
    return 2 * rate / (1 + rate + (1 - rate) / 2)


def merged(cases: Sequence[TaskRateContribution]) -> list[TaskRateContribution]:
    """Return the cases with one case for each name."""
    sums: dict[str, Share] = {}
    for case in cases:
        numerator, denominator = sums.get(case.name, Share(0, 0))
        sums[case.name] = Share(numerator + case.share.numerator, denominator + case.share.denominator)
    return [TaskRateContribution(name, name, share) for name, share in sums.items()]
