"""Satisfied goals by kind (the paper's table "goal satisfaction rates")."""

from __future__ import annotations

from collections.abc import Mapping

from eai.abilities.verdict import Tally, Verdict
from eai.metrics.rate import Rate

KINDS = ("state", "relation", "action")
"""The kinds of goal, as records name them."""

GOAL_COLUMNS = (*(f"{kind}_goal" for kind in KINDS), "total_goal")
"""The names of the metrics."""


def goal_rates(tallies: Mapping[str, Tally]) -> dict[str, Rate]:
    """What one answer contributes to the goal satisfaction rates; nothing where its goals are not known."""
    known = [tallies.get(kind, Tally(0, 0)) for kind in KINDS]
    rates = [Rate(*tally) for tally in known]
    whole = Rate(sum(t.satisfied for t in known), sum(t.total for t in known))
    return dict(zip(GOAL_COLUMNS, (*rates, whole), strict=True))


def tallies_of(verdict: Verdict) -> Mapping[str, Tally]:
    """The satisfied goals by kind, as the verdict has them."""
    return {} if verdict.goals is None else verdict.goals._asdict()
