from __future__ import annotations

import json

import pytest

from cli.test_matrix import DOMAINS, MORE, here
from command_line import Command
from sweeps import swept

SHARED = (here,)
"""The fixture that works in an empty folder in which the modules of the worlds are found."""

NONE = "its tasks yield no question"
"""The reason of `eai export questions` if a world is too small for it."""


@pytest.mark.parametrize("domain", [*DOMAINS, *swept(*MORE)])
def test_questions_are_asked_of_every_domain_that_is_large_enough(eai: Command, domain: str) -> None:
    outcome = eai("export", "questions", "--domain", domain, "--n", 5, "--out", "questions.jsonl")
    assert outcome.status == 0 or NONE in outcome.err


def test_the_command_reports_the_written_questions(eai: Command) -> None:
    outcome = eai("export", "questions", "--domain", "lamps:lamps", "--n", "4", "--out", "q.jsonl", "--json")
    assert json.loads(outcome.out).items() >= {"file": "q.jsonl", "questions": 4}.items()
