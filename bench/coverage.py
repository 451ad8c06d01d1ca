"""Measure how often 95 % intervals contain the true value, for tasks that are near copies.

    python -m bench coverage [--samples 500]

Runs are simulated: 26 names with up to 35 tasks each. The chance of success of a name has a beta distribution
with the measured intraclass correlation (0.6). The intervals of reports are compared with alternatives that
reports do not use. Each cell of the table has the coverage in percent and the mean half width in points.
"""

from __future__ import annotations

import argparse
import math
import random
from collections.abc import Callable, Sequence
from statistics import fmean, quantiles

from bench.record import add_write_option, write_rows
from eai.results.certainty import (
    ConfidenceIntervals,
    Interval,
    TaskRateContribution,
    compute_difference_intervals,
    compute_rate_intervals,
    compute_rate_with_residuals_of_sampling_units,
    sum_shares_by_task_name,
)
from extensions.adaptive.abilities import ability
from results.near_copies import SIZES as NAME_SIZES
from results.near_copies import expected_f1, matches, successes
from studies.effects import answers, correlation, log_odds

DRAWS = 200
RATES = (0.01, 0.02, 0.05, 0.1, 0.17, 0.25, 0.5, 0.75, 0.83, 0.9, 0.95, 0.98, 0.99)
PAIRS = ((0.01, 0.1), (0.05, 0.2), (0.3, 0.5), (0.5, 0.5), (0.8, 0.95), (0.97, 0.99))

Method = Callable[[Sequence[TaskRateContribution], random.Random], Interval]


def require_certainty(cases: Sequence[TaskRateContribution]) -> ConfidenceIntervals:
    """Return the uncertainty of a rate, or raise if the rate has no cases."""
    found = compute_rate_intervals(cases)
    if found is None:
        raise ValueError("no cases: a rate needs at least one")
    return found


def compute_reported_interval(cases: Sequence[TaskRateContribution], generator: random.Random) -> Interval:
    """Return the interval that reports show."""
    return require_certainty(cases).interval


def compute_interval_for_independent_tasks(
    cases: Sequence[TaskRateContribution], generator: random.Random
) -> Interval:
    """Return the interval for independent tasks."""
    return require_certainty(cases).by_task


def compute_bootstrap_interval(cases: Sequence[TaskRateContribution], generator: random.Random) -> Interval:
    """Return the percentile interval of a bootstrap over names."""
    sums = list(sum_shares_by_task_name(cases).values())
    values = []
    for _ in range(DRAWS):
        drawn = generator.choices(sums, k=len(sums))
        values.append(100 * sum(s.numerator for s in drawn) / sum(s.denominator for s in drawn))
    cuts = quantiles(values, n=40, method="inclusive")
    return Interval(cuts[0], cuts[-1])


def compute_plain_wilson_interval(
    cases: Sequence[TaskRateContribution], generator: random.Random
) -> Interval:
    """Return Wilson's interval with the observed design effect; one task per name if nothing varies."""
    rate = compute_rate_with_residuals_of_sampling_units(sum_shares_by_task_name(cases))
    if rate is None:
        raise ValueError("no cases: a rate needs at least one")
    p, observed = rate.value, rate.observed_variance
    number = p * (1 - p) / observed if observed else 1 / sum(w * w for w in rate.weights.values())
    spread = 1.96**2 / number
    middle = (p + spread / 2) / (1 + spread)
    half = math.sqrt(spread * (p * (1 - p) + spread / 4)) / (1 + spread)
    return Interval(100 * (middle - half), 100 * (middle + half))


METHODS: dict[str, Method] = {
    "reports": compute_reported_interval,
    "independent": compute_interval_for_independent_tasks,
    "bootstrap": compute_bootstrap_interval,
    "plain Wilson": compute_plain_wilson_interval,
}


def main() -> None:
    """Simulate the runs and print the tables of coverage."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--samples", type=int, default=500)
    add_write_option(parser)
    arguments = parser.parse_args()
    samples, rows = arguments.samples, []
    print("rate".ljust(16), *(name.rjust(14) for name in METHODS))
    for rate in RATES:
        generator = make_seeded_generator(f"rate/{rate}")
        runs = [successes(generator, rate) for _ in range(samples)]
        rows.append(print_row(f"yes/no, {100 * rate:.0f} %", runs, 100 * rate))
    for rate in RATES:
        generator = make_seeded_generator(f"f1/{rate}")
        runs = [matches(generator, rate) for _ in range(samples)]
        rows.append(print_row(f"F1, {100 * expected_f1(rate):.0f} %", runs, 100 * expected_f1(rate)))
    for pair in PAIRS:
        generator = make_seeded_generator(f"difference/{pair}")
        found = [
            compute_difference_intervals(*(successes(generator, rate) for rate in pair))
            for _ in range(samples)
        ]
        intervals = [each.interval for each in found if each is not None]
        name = f"from {100 * pair[0]:.0f} to {100 * pair[1]:.0f} %"
        within = format_coverage(intervals, 100 * (pair[1] - pair[0]))
        rows.append([name, strip_alignment(within), "", "", ""])
        print(name.ljust(16), within)
    print_effect_coverage(samples)
    if arguments.write:
        write_rows("coverage", rows)


def print_effect_coverage(samples: int) -> None:
    """Print the coverage of intervals of log odds, rank correlations and abilities, in hundredths.

    Nine models answer. Chances of success and cofactors are equal within a name. The truth is computed on
    20,000 tasks.
    """
    whole = answers(make_seeded_generator("effects"), [1] * 20_000)
    odds, rho, logit = log_odds(whole), correlation(whole), ability(whole)
    for title, sizes in (("26 names", NAME_SIZES), ("100 tasks", [1] * 100)):
        generator = make_seeded_generator(f"effects/{title}")
        runs = [answers(generator, sizes) for _ in range(samples)]
        pairs = (
            ("log odds", log_odds, odds),
            ("rank correlation", correlation, rho),
            ("ability", ability, logit),
        )
        for name, estimate, truth in pairs:
            found = [estimate(run) for run in runs]
            intervals = [
                Interval(100 * (e.low or 0), 100 * (e.high or 0)) for e in found if e.low is not None
            ]
            print(f"{name}, {title}".ljust(28), format_coverage(intervals, 100 * (truth.value or 0)))


def make_seeded_generator(name: str) -> random.Random:
    """Return a random generator for one line of a table, so that lines do not depend on each other."""
    return random.Random(name)  # noqa: S311 - reproducible, not secret


def print_row(name: str, runs: Sequence[Sequence[TaskRateContribution]], truth: float) -> list[str]:
    """Print and return one line: the coverage of every method on the same simulated runs."""
    generator = make_seeded_generator(name)
    cells = [format_coverage([method(run, generator) for run in runs], truth) for method in METHODS.values()]
    print(name.ljust(16), *cells)
    return [name, *map(strip_alignment, cells)]


def strip_alignment(text: str) -> str:
    """Return a cell without the spaces that align it."""
    return text.strip().replace("( ", "(")


def format_coverage(intervals: Sequence[Interval], truth: float) -> str:
    """Return the coverage and the mean half width as a cell of the table."""
    within = 100 * fmean(interval.low <= truth <= interval.high for interval in intervals)
    width = fmean(interval.high - interval.low for interval in intervals) / 2
    return f"{within:6.1f} ({width:4.1f})".rjust(14)
