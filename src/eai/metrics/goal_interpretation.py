"""The paper's metrics of goal interpretation (table "all goal evaluation results")."""

from __future__ import annotations

from eai.abilities.verdict import Confusion, Verdict, fields_of
from eai.metrics.goals import KINDS
from eai.metrics.rate import Rate, add, confusion_rates, share
from eai.world.fault import FaultKind

OVERALL = "overall"
"""The prefix of the rates over all goals."""

ALL = "all"
"""The key in a verdict's counts of all goals, where they are more than those of the three kinds."""

TABLE_COLUMNS = tuple(
    f"{part}.{measure}" for part in (*KINDS, OVERALL) for measure in ("precision", "recall", "f1")
)
"""What a terminal shows: the paper's columns."""


def contribution(verdict: Verdict) -> dict[str, Rate]:
    """What one answer contributes to each rate.

    Besides the paper's columns: ``parsing``, unreadable answers among all; ``ill_formed`` and
    ``hallucination``, predicted goals that lack a field or name what does not exist, among all predicted.
    """
    counts = {kind: _of(verdict, kind) for kind in KINDS}
    whole = _of(verdict, ALL) if ALL in (verdict.counts or {}) else add(counts.values())
    rates: dict[str, Rate] = {}
    for name, confusion in {**counts, OVERALL: whole}.items():
        rates |= confusion_rates(name, confusion)
    details = fields_of(verdict)
    predicted = _number(details.get("predicted"))
    unreadable = verdict.error is not None and verdict.error.kind is FaultKind.PARSING
    return {
        **rates,
        "parsing": share(unreadable),
        "ill_formed": Rate(_number(details.get("ill_formed")), predicted),
        "hallucination": Rate(_number(details.get("hallucinated")), predicted),
    }


def _of(verdict: Verdict, key: str) -> Confusion:
    found = (verdict.counts or {}).get(key)
    return found if isinstance(found, Confusion) else Confusion(0, 0, 0)


def _number(value: object) -> int:
    """A count as it is, or the length of a list of what is counted."""
    if isinstance(value, int):
        return value
    return len(value) if isinstance(value, list | tuple) else 0
