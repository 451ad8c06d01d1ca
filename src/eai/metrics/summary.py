"""The metrics of every ability, and which of them the terminal's tables show."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import Verdict
from eai.metrics import action_sequencing
from eai.metrics.rate import Rate

_SUMMARIES: Mapping[Ability, Callable[[Sequence[Verdict], Protocol], dict[str, Rate]]] = {
    Ability.ACTION_SEQUENCING: action_sequencing.summarise,
}

TABLE_COLUMNS: Mapping[Ability, tuple[str, ...]] = {
    Ability.ACTION_SEQUENCING: action_sequencing.TABLE_COLUMNS,
}
"""The columns of the table that a terminal shows, by ability."""


def summarise(verdicts: Sequence[Verdict], ability: Ability, protocol: Protocol) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name."""
    return _SUMMARIES[ability](verdicts, protocol)
