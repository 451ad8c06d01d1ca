"""pass@k (at least one of k answers is right) and pass^k (all are right), from several answers to each task.

Both are unbiased estimates from n answers of which c are right. They are means over tasks, because the
answers to one task are not independent. ``docs/reports.md`` has the definitions and their sources.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import comb

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability
from eai.base.json_value import Json
from eai.results.certainty import TaskRateContribution, TaskRateContributions, compute_rate_intervals
from eai.results.rate import compute_rate
from eai.results.table import Column, Estimate, Row, TextCell, collect_rows_in_table
from eai.tasks.share import Share


def find_success_metric(ability: Ability) -> str | None:
    """Return the main metric for the success of a whole answer, or None if the ability has no such metric."""
    declared = get_declaration(ability)
    return next((metric for metric in declared.overview_headings if metric in declared.yes_no_metrics), None)


def map_pass_at_k_metrics_to_contributions(
    contributions_by_epoch: Sequence[TaskRateContributions],
) -> dict[str, TaskRateContributions]:
    """Return a mapping from the metrics ``pass@k`` and ``pass^k`` to the contributions of the tasks.

    k runs from 1 to the number of answers to a task.

    Args:
        contributions_by_epoch: for each epoch, the contributions of tasks: 1 of 1 if the answer is right, 0
            of 1 if it is wrong. A task with fewer than k scored answers is left out for that k.
    """
    counts: dict[tuple[str, str], tuple[int, int]] = {}
    for contribution in (
        contribution for contributions in contributions_by_epoch for contribution in contributions
    ):
        n, c = counts.get(contribution[:2], (0, 0))
        counts[contribution[:2]] = (
            n + int(contribution.share.denominator),
            c + int(contribution.share.numerator),
        )
    contributions_by_metric: dict[str, TaskRateContributions] = {}
    for k in range(1, len(contributions_by_epoch) + 1):
        counts_of_tasks = [(task, name, n, c) for (task, name), (n, c) in counts.items() if n >= k]
        contributions_by_metric[f"pass@{k}"] = [
            TaskRateContribution(task, name, Share(1 - comb(n - c, k) / comb(n, k), 1))
            for task, name, n, c in counts_of_tasks
        ]
        contributions_by_metric[f"pass^{k}"] = [
            TaskRateContribution(task, name, Share(comb(c, k) / comb(n, k), 1))
            for task, name, n, c in counts_of_tasks
        ]
    return contributions_by_metric


_SHARES = tuple([Column(name, digits=1, is_number=True) for name in ("pass@k", "pass^k")])


@collect_rows_in_table("passes", ("run", "n", "k", *_SHARES))
def make_pass_at_k_table(runs: Mapping[str, Sequence[TaskRateContributions]]) -> Iterator[Row]:
    """Several answers to each task.

    A task has n answers, of which c are right. k of the n answers are drawn. `pass@k` is the probability that
    at least one of the k is right, 1 - C(n - c, k) / C(n, k), in percent, as the mean over tasks. `pass^k` is
    the probability that all k are right, C(c, k) / C(n, k). For k = 1 both are the share of right answers
    """
    for name, epochs in runs.items():
        n, contributions = len(epochs), map_pass_at_k_metrics_to_contributions(epochs)
        for k in sorted({*(2**i for i in range(n.bit_length())), n}):  # 1, 2, 4, ... and n
            yield (
                TextCell(name),
                n,
                k,
                Estimate.from_task_rate_contributions(contributions[f"pass@{k}"]),
                Estimate.from_task_rate_contributions(contributions[f"pass^{k}"]),
            )


def strip_epoch(model: str) -> str:
    """Return the name of a model without the suffix for an epoch (round of answers), if it has one."""
    return re.sub(r"\.epoch_[0-9]+$", "", model)


def pass_at_k_to_json(contributions_by_metric: Mapping[str, TaskRateContributions]) -> dict[str, Json]:
    """Return pass@k and pass^k as in ``summary.json``: rates with their intervals."""
    rates: dict[str, Json] = {}
    for name, contributions in contributions_by_metric.items():
        certainty = compute_rate_intervals(contributions)
        interval = None if certainty is None else list(certainty.interval)
        rate = compute_rate(contribution.share for contribution in contributions)
        rates[name] = {**rate.to_json(), "interval": interval}
    return rates
