"""The options of replanning, and the experiment that they come to."""

from __future__ import annotations

from typing import Any

import pytest

from eai.abilities.attempt_options import AttemptOptions
from eai.base.errors import InputError
from eai.studies.attempts.study import REPLANNING


@pytest.mark.parametrize(
    ("choices", "attempts"),
    [
        ({}, None),
        # What cannot matter is as in a plain run:
        ({"world": "continue", "feedback_form": "chat", "slip_notice": "silent", "slip_seed": 3}, None),
        ({"feedback": "none", "until": "done"}, None),
        ({"replans": 1}, AttemptOptions(1, feedback="explained")),
        ({"replans": 1, "feedback": "none", "feedback_form": "chat"}, AttemptOptions(1)),
        (
            {"replans": 1, "feedback_form": "chat"},
            AttemptOptions(1, feedback="explained", form="chat"),
        ),
        (
            {"replans": 2, "world": "continue"},
            AttemptOptions(2, "continue", "explained", until="goal"),
        ),
        (
            {"replans": 2, "world": "continue", "feedback": "state", "until": "done"},
            AttemptOptions(2, "continue", "state"),
        ),
        ({"slip": 0.1}, AttemptOptions(slip=0.1, slip_seed=7)),
        (
            {"slip": 0.1, "slip_notice": "silent", "slip_seed": 0},
            AttemptOptions(slip=0.1, slip_seed=0, notice="silent"),
        ),
        ({"until": "goal"}, AttemptOptions(until="goal")),
    ],
)
def test_options_of_attempts_give_the_attempts_and_their_label(
    choices: dict[str, Any], attempts: AttemptOptions | None
) -> None:
    assert REPLANNING.options.read("attempts", {"slip_seed": 7, **choices}).attempts == attempts


@pytest.mark.parametrize(
    ("choices", "complaint"),
    [
        (
            {"feedback": "kind"},
            "attempts.feedback kind: has no effect without further attempts; also give attempts.replans",
        ),
        ({"replans": 1, "feedback": "explaned"}, "attempts.feedback: expected 'none', 'kind', "),
        ({"world": "restarted"}, "attempts.world: expected 'restart' or 'continue', found 'restarted'"),
        ({"feedback_form": "letter"}, "attempts.feedback_form: expected 'prompt' or 'chat'"),
        ({"slip_notice": "loud"}, "attempts.slip_notice: expected 'detected' or 'silent'"),
        ({"until": "never"}, "attempts.until: expected 'goal' or 'done'"),
        ({"replans": -1}, "attempts.replans: expected greater than or equal to 0, found -1"),
        (
            {"replans": 1, "feedback": "state"},
            "feedback: state needs the world continue, since a restarted world is in its initial state",
        ),
    ],
)
def test_contradicting_or_unknown_options_of_attempts_are_refused(
    choices: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(InputError) as caught:
        REPLANNING.options.read("attempts", choices)
    assert str(caught.value).startswith(complaint)
