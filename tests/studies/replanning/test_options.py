"""The options of replanning, and the experiment that they come to."""

from __future__ import annotations

from typing import Any

import pytest

from eai.abilities.replanning_options import ReplanningOptions
from eai.base.errors import InputError
from eai.studies.replanning.study import REPLANNING


@pytest.mark.parametrize(
    ("choices", "options"),
    [
        ({}, None),
        # What cannot matter is as in a plain run:
        ({"world": "continue", "feedback_form": "chat", "slip_notice": "silent", "slip_seed": 3}, None),
        ({"feedback": "none", "until": "done"}, None),
        ({"replans": 1}, ReplanningOptions(1, feedback="explained")),
        ({"replans": 1, "feedback": "none", "feedback_form": "chat"}, ReplanningOptions(1)),
        (
            {"replans": 1, "feedback_form": "chat"},
            ReplanningOptions(1, feedback="explained", form="chat"),
        ),
        (
            {"replans": 2, "world": "continue"},
            ReplanningOptions(2, "continue", "explained", until="goal"),
        ),
        (
            {"replans": 2, "world": "continue", "feedback": "state", "until": "done"},
            ReplanningOptions(2, "continue", "state"),
        ),
        ({"slip": 0.1}, ReplanningOptions(slip=0.1, slip_seed=7)),
        (
            {"slip": 0.1, "slip_notice": "silent", "slip_seed": 0},
            ReplanningOptions(slip=0.1, slip_seed=0, notice="silent"),
        ),
        ({"until": "goal"}, ReplanningOptions(until="goal")),
    ],
)
def test_choices_give_the_options_of_replanning(
    choices: dict[str, Any], options: ReplanningOptions | None
) -> None:
    assert REPLANNING.options.read("replanning", {"slip_seed": 7, **choices}).replanning == options


@pytest.mark.parametrize(
    ("choices", "complaint"),
    [
        (
            {"feedback": "kind"},
            "replanning.feedback kind: has no effect without further attempts; also give replanning.replans",
        ),
        ({"replans": 1, "feedback": "explaned"}, "replanning.feedback: expected 'none', 'kind', "),
        ({"world": "restarted"}, "replanning.world: expected 'restart' or 'continue', found 'restarted'"),
        ({"feedback_form": "letter"}, "replanning.feedback_form: expected 'prompt' or 'chat'"),
        ({"slip_notice": "loud"}, "replanning.slip_notice: expected 'detected' or 'silent'"),
        ({"until": "never"}, "replanning.until: expected 'goal' or 'done'"),
        ({"replans": -1}, "replanning.replans: expected greater than or equal to 0, found -1"),
        (
            {"replans": 1, "feedback": "state"},
            "feedback state: has no effect if attempts restart in the initial state; also give replanning",
        ),
    ],
)
def test_contradicting_or_unknown_options_of_replanning_are_refused(
    choices: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(InputError) as caught:
        REPLANNING.options.read("replanning", choices)
    assert str(caught.value).startswith(complaint)
