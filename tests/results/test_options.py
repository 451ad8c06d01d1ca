"""Options of scoring: their defaults and their minima."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from eai.abilities.protocol import Protocol
from eai.pddl.planning import PlannerChoice
from eai.results.options import ScoringOptions
from eai.tasks.source import ErrataChoice


@pytest.mark.parametrize(
    ("name", "least"), [("planner_seconds", 1), ("planner_memory", 64), ("workers", 1), ("look_back", 1)]
)
def test_a_number_below_its_minimum_is_refused(name: str, least: int) -> None:
    assert getattr(ScoringOptions(**{name: least}), name) == least
    with pytest.raises(ValidationError, match=f"greater than or equal to {least}"):
        ScoringOptions(**{name: least - 1})


def test_default_options_follow_the_paper() -> None:
    options = ScoringOptions()
    assert options.model_dump() == {
        "protocol": Protocol.STRICT,
        "errata": ErrataChoice.CURRENT,
        "planner": PlannerChoice.AUTO,
        "planner_seconds": None,
        "planner_memory": None,
        "workers": 1,
        "explanations": True,
        "allow_missing": False,
        "look_back": None,
    }
