"""The schema of answers over HTTP: what a server gets, in both household benchmarks and another one."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from by_path import ROOT
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.benchmarks.suite import open_suite
from eai.run.job import DecodingOptions, QuestionJob
from eai.studies.variation import ModelEndpoint
from eai.tasks.prompts.prompt import Prompt
from processes import eai
from run.server import Reply, serve

LOCAL = "openai-api/local/scripted"
WORDS = {
    "virtualhome": {"soap", "1002", "CLOSED"},
    "behavior": {"LEFT_GRASP", "candle_0", "inside", "candle.n.01_1"},
    "lamps:lamps": {"PRESS", "lamp_1", "lit"},
}
"""Some words that the answer schema of each domain's first task must allow."""


STRUCTURED = ("--with", "generation.structured=true")


def test_answers_with_and_without_a_schema_are_different_requests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples/lamps")
    how = ("--limit", 1, "-M", "api_key=none", "--out", tmp_path, "--ability", "action_sequencing")
    asked = []
    with serve(defaultdict(lambda: [Reply("[]")])) as served:
        model = ("--model", LOCAL, "--model-base-url", served.url, "--domain", "lamps:lamps")
        for form in ((), STRUCTURED, (), STRUCTURED):
            outcome = eai("run", *model, *how, *form)
            assert outcome.status == 0, outcome.err
            asked.append(len(served.log.requests))
    assert asked == [1, 2, 2, 2]


def test_another_key_is_no_other_request() -> None:
    """A user who replaces a key would otherwise pay for all answers again."""
    suite = open_suite("virtualhome", Ability.TRANSITION_MODELING)
    prompts = {"27_2": Prompt("What does WALK need?")}
    arguments = ({"api_key": "old"}, {"api_key": "new"}, {}, {"api_key": "new", "rate": 1})
    digests = [QuestionJob(ModelEndpoint("a/b", each), suite, prompts).sha256 for each in arguments]
    assert digests[0] == digests[1] == digests[2] != digests[3]


def test_another_schema_is_another_request(monkeypatch: pytest.MonkeyPatch) -> None:
    """The schema may be of another version, or of a domain whose words have changed since."""
    free = QuestionJob(
        ModelEndpoint("openai/gpt-4o"),
        open_suite("virtualhome", Ability.TRANSITION_MODELING),
        {"27_2": Prompt("What does WALK need?")},
    )
    held = replace(free, decoding=DecodingOptions(structured=True))
    before = (free.sha256, held.sha256)
    assert before == (free.sha256, held.sha256)
    assert before[0] != before[1]
    monkeypatch.setattr("eai.run.job.make_answer_schema", lambda *asked: {"type": "string"})
    assert free.sha256 == before[0]
    assert held.sha256 != before[1]


def objects(schema: Any) -> list[dict[str, Any]]:
    if isinstance(schema, dict):
        inner = [each for value in schema.values() for each in objects(value)]
        return [schema, *inner] if schema.get("type") == "object" else inner
    return [each for value in schema for each in objects(value)] if isinstance(schema, list) else []


def test_a_server_gets_the_words_of_each_task_in_the_schema(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples/lamps")
    domains = [part for name in WORDS for part in ("--domain", name)]
    how = (*STRUCTURED, "--planner", "none", "--limit", 1, "-M", "api_key=none", "--out", tmp_path)
    with serve(defaultdict(lambda: [Reply("{}")])) as served:
        outcome = eai("run", "--model", LOCAL, "--model-base-url", served.url, *domains, *how)
    assert outcome.status == 0, outcome.err
    asked = [request["response_format"]["json_schema"] for request in served.log.requests]
    assert [each["strict"] for each in asked] == [True] * len(PAPER_ABILITIES) * len(WORDS)
    for place, words in enumerate(WORDS.values()):
        told = json.dumps(asked[len(PAPER_ABILITIES) * place : len(PAPER_ABILITIES) * (place + 1)])
        assert {word for word in words if f'"{word}"' not in told} == set()
    for each in objects([one["schema"] for one in asked]):
        assert each["additionalProperties"] is False
        assert each["required"] == list(each["properties"])
