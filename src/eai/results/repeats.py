"""Several answers to each task: whether at least one of them is right (pass@k), or all are (pass^k).

Both are unbiased estimates from n answers of which c are right, and means over tasks: the answers to one task
are no independent cases. Their definitions, with sources, are in ``docs/reports.md``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import comb

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import Ability
from eai.base.json_value import Json
from eai.results.certainty import Case, Cases, certainty_of_rate
from eai.results.rate import rate_of
from eai.results.table import Column, Estimate, Label, Row, make_table
from eai.tasks.share import Share


def find_success_metric(ability: Ability) -> str | None:
    """The metric that says whether an answer is right as a whole; None where none of the main ones does."""
    declared = declaration_of(ability)
    return next((metric for metric in declared.overview_headings if metric in declared.yes_no_metrics), None)


def pass_cases(epochs: Sequence[Cases]) -> dict[str, Cases]:
    """The contribution of each task to ``pass@k`` and ``pass^k``, for k from 1 to the number of answers.

    Args:
        epochs: for each answer to the tasks, whether it is right, by task. Tasks with fewer than k answers
            that count are left out for that k.
    """
    counts: dict[tuple[str, str], tuple[int, int]] = {}
    for case in (case for cases in epochs for case in cases):
        n, c = counts.get(case[:2], (0, 0))
        counts[case[:2]] = n + int(case.share.denominator), c + int(case.share.numerator)
    found: dict[str, Cases] = {}
    for k in range(1, len(epochs) + 1):
        enough = [(task, name, n, c) for (task, name), (n, c) in counts.items() if n >= k]
        found[f"pass@{k}"] = [
            Case(task, name, Share(1 - comb(n - c, k) / comb(n, k), 1)) for task, name, n, c in enough
        ]
        found[f"pass^{k}"] = [
            Case(task, name, Share(comb(c, k) / comb(n, k), 1)) for task, name, n, c in enough
        ]
    return found


_SHARES = tuple([Column(name, digits=1, is_number=True) for name in ("pass@k", "pass^k")])


@make_table("passes", ("run", "n", "k", *_SHARES))
def passes_table(runs: Mapping[str, Sequence[Cases]]) -> Iterator[Row]:
    """Several answers to each task.

    Of n answers to a task c are right. `pass@k` is the mean over tasks of 1 - C(n - c, k) / C(n, k): at least
    one of k is right. `pass^k` is that of C(c, k) / C(n, k): all of k are. For k = 1 both are the share of
    right answers. Percent
    """
    for name, epochs in runs.items():
        n, found = len(epochs), pass_cases(epochs)
        for k in sorted({*(2**i for i in range(n.bit_length())), n}):  # 1, what it is doubled to, and n
            yield (
                Label(name),
                n,
                k,
                Estimate.from_cases(found[f"pass@{k}"]),
                Estimate.from_cases(found[f"pass^{k}"]),
            )


def strip_epoch(model: str) -> str:
    """The name of a model in the results of one epoch without that epoch; other names are as they are."""
    return re.sub(r"\.epoch_[0-9]+$", "", model)


def pass_cases_to_json(found: Mapping[str, Cases]) -> dict[str, Json]:
    """The same as rates with their intervals, as ``summary.json`` has them."""
    written: dict[str, Json] = {}
    for name, cases in found.items():
        certainty = certainty_of_rate(cases)
        interval = None if certainty is None else list(certainty.interval)
        rate = rate_of(case.share for case in cases)
        written[name] = {**rate.to_json(), "interval": interval}
    return written
