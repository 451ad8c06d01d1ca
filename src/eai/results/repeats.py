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
from eai.results.certainty import TaskContribution, TaskContributions, compute_rate_intervals
from eai.results.rate import compute_rate
from eai.results.table import Column, Estimate, Row, TextCell, collect_rows_in_table
from eai.tasks.share import Share


def find_success_metric(ability: Ability) -> str | None:
    """Return the main metric for the success of a whole answer, or None if the ability has no such metric."""
    declared = get_declaration(ability)
    return next((metric for metric in declared.overview_headings if metric in declared.yes_no_metrics), None)


def make_task_contributions_by_pass_at_k(
    cases_by_epoch: Sequence[TaskContributions],
) -> dict[str, TaskContributions]:
    """Return a mapping from the metrics ``pass@k`` and ``pass^k`` to the contributions of the tasks.

    k runs from 1 to the number of answers to a task.

    Args:
        cases_by_epoch: for each epoch, whether the answer to each task is right. A task with fewer than k
            scored answers is left out for that k.
    """
    counts: dict[tuple[str, str], tuple[int, int]] = {}
    for case in (case for cases in cases_by_epoch for case in cases):
        n, c = counts.get(case[:2], (0, 0))
        counts[case[:2]] = n + int(case.share.denominator), c + int(case.share.numerator)
    cases_by_metric: dict[str, TaskContributions] = {}
    for k in range(1, len(cases_by_epoch) + 1):
        counts_of_tasks = [(task, name, n, c) for (task, name), (n, c) in counts.items() if n >= k]
        cases_by_metric[f"pass@{k}"] = [
            TaskContribution(task, name, Share(1 - comb(n - c, k) / comb(n, k), 1))
            for task, name, n, c in counts_of_tasks
        ]
        cases_by_metric[f"pass^{k}"] = [
            TaskContribution(task, name, Share(comb(c, k) / comb(n, k), 1))
            for task, name, n, c in counts_of_tasks
        ]
    return cases_by_metric


_SHARES = tuple([Column(name, digits=1, is_number=True) for name in ("pass@k", "pass^k")])


@collect_rows_in_table("passes", ("run", "n", "k", *_SHARES))
def make_pass_at_k_table(runs: Mapping[str, Sequence[TaskContributions]]) -> Iterator[Row]:
    """Several answers to each task.

    A task has n answers, of which c are right. k of the n answers are drawn. `pass@k` is the probability that
    at least one of the k is right, 1 - C(n - c, k) / C(n, k), in percent, as the mean over tasks. `pass^k` is
    the probability that all k are right, C(c, k) / C(n, k). For k = 1 both are the share of right answers
    """
    for name, epochs in runs.items():
        n, cases = len(epochs), make_task_contributions_by_pass_at_k(epochs)
        for k in sorted({*(2**i for i in range(n.bit_length())), n}):  # 1, 2, 4, ... and n
            yield (
                TextCell(name),
                n,
                k,
                Estimate.from_cases(cases[f"pass@{k}"]),
                Estimate.from_cases(cases[f"pass^{k}"]),
            )


def strip_epoch(model: str) -> str:
    """Return the name of a model without the suffix for an epoch (round of answers), if it has one."""
    return re.sub(r"\.epoch_[0-9]+$", "", model)


def pass_at_k_to_json(cases_by_metric: Mapping[str, TaskContributions]) -> dict[str, Json]:
    """Return pass@k and pass^k as in ``summary.json``: rates with their intervals."""
    rates: dict[str, Json] = {}
    for name, cases in cases_by_metric.items():
        certainty = compute_rate_intervals(cases)
        interval = None if certainty is None else list(certainty.interval)
        rate = compute_rate(case.share for case in cases)
        rates[name] = {**rate.to_json(), "interval": interval}
    return rates
