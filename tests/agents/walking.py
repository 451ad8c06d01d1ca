"""A second ability with several turns, as another distribution would provide it: list possible actions."""

from __future__ import annotations

from dataclasses import replace

from eai.abilities.declaration import MetricColumn
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Share, make_rate_contribution_of_answer
from eai.agents.declaration import ACTING
from eai.agents.verdict import EpisodeVerdict


def contributions(verdict: EpisodeVerdict) -> dict[str, Share]:
    possible = sum(turn.fault is None for turn in verdict.action_turns)
    return {
        "won": make_rate_contribution_of_answer(bool(verdict.success)),
        "possible": Share(possible, len(verdict.action_turns)),
    }


WALKING = replace(
    ACTING,
    ability=Ability("walking"),
    title="Walking",
    short_title="walk",
    contributions=contributions,
    columns=(MetricColumn("won", "Success", "Won"), MetricColumn("possible", "Actions", "Possible")),
    terminal_metrics=("won", "possible"),
    overview_headings={"won": "Won"},
    yes_no_metrics=frozenset({"won"}),
    combine_epochs=None,
)
