"""The metrics of a run, as its ability declares them."""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability
from eai.abilities.share import Shares
from eai.abilities.verdict import Verdict
from eai.metrics.rate import NOTHING, Rate, total


def summarise(verdicts: Sequence[Verdict], ability: Ability) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name, over the verdicts that are not excluded.

    Metrics without any verdict are there all the same, as nothing of nothing.
    """
    declared = DECLARATIONS[ability]
    nothing = dict.fromkeys(declared.contributions(declared.verdict()), NOTHING)
    return {**nothing, **total(contributions(verdicts, ability))}


def contributions(verdicts: Sequence[Verdict], ability: Ability) -> list[Shares]:
    """What each verdict of a run that is not excluded contributes to each metric, in order."""
    declared = DECLARATIONS[ability]
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    return [declared.contributions(verdict) for verdict in declared.of_run(scored)]
