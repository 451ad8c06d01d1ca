from __future__ import annotations

import json

import pytest

from eai.abilities.verdict import (
    Confusion,
    ErrorReport,
    GoalTallies,
    Json,
    PlannerOutcome,
    SubgoalCategory,
    Tally,
    Verdict,
    fields_of,
)
from eai.world.fault import FaultKind


@pytest.mark.parametrize(
    ("tallies", "satisfied"),
    [
        ([(0, 0), (0, 0), (0, 0)], True),
        ([(1, 1), (2, 2), (0, 0)], True),
        ([(1, 1), (1, 2), (0, 0)], False),
        ([(0, 1), (2, 2), (1, 1)], False),
        ([(1, 1), (2, 2), (0, 1)], False),
    ],
)
def test_all_goals_are_satisfied_if_those_of_every_kind_are(
    tallies: list[tuple[int, int]], *, satisfied: bool
) -> None:
    assert GoalTallies(*(Tally(*tally) for tally in tallies)).all_satisfied is satisfied


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [
        (Verdict(), {"status": "scored", "excluded_reason": None, "error": None, "repairs": []}),
        (Verdict(excluded="no goal"), {"status": "excluded", "excluded_reason": "no goal"}),
        (
            Verdict(error=ErrorReport(FaultKind.PARSING, None, "nothing")),
            {"error": {"kind": "parsing", "step": None, "detail": "nothing"}},
        ),
        (
            Verdict(goals=GoalTallies(Tally(1, 2), Tally(0, 0), Tally(3, 3))),
            {"goals": {"state": [1, 2], "relation": [0, 0], "action": [3, 3]}},
        ),
        (Verdict(counts={"state": Confusion(1, 2, 3)}), {"counts": {"state": [1, 2, 3]}}),
        (
            Verdict(counts={"effect": {"object_states": Confusion(1, 2, 3)}}),
            {"counts": {"effect": {"object_states": [1, 2, 3]}}},
        ),
        (Verdict(category=SubgoalCategory.RUNTIME), {"category": "runtime"}),
        (Verdict(planner=PlannerOutcome.TIME), {"planner": "time"}),
        (
            Verdict(executable=True, success=False, additional_steps=0),
            {"executable": True, "additional_steps": 0},
        ),
        (Verdict(details={"times_counted": 2}), {"times_counted": 2}),
    ],
)
def test_a_verdict_as_json_fields(verdict: Verdict, expected: dict[str, Json]) -> None:
    fields = fields_of(verdict)
    assert {key: fields[key] for key in expected} == expected
    assert json.loads(json.dumps(fields)) == fields
