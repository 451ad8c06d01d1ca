"""Any text of a model has a verdict and an explanation, and scoring it again gives equal verdicts."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.suite import Suite, open_suite
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.results.codec import dataclass_to_json, verdict_to_record_fields
from eai.tasks.source import Source
from made_answers import made_answers
from protocols import PROTOCOLS

MADE_UP = make_task(goals=("state OPEN fridge.10", "relation ONTOP cup.13 bed.20", "action TOUCH|TYPE"))
STRICT = virtualhome_scorer(MADE_UP)
ACTIONS = sorted(virtualhome.make_domain_with_checks_in_paper_order().compiled_operators)
NAMES = [obj.name for obj in MADE_UP.scene.objects]

SYNTAX = [
    "{",
    "}",
    "[",
    "]",
    '"',
    "'",
    ",",
    ":",
    "\\",
    "```",
    "```json",
    "<think>",
    "</think>",
    "<|",
    "|>",
    "10",
    "1e999",
    "-0",
    "null",
    "NaN",
]
WRITTEN = ['"WALK": ["fridge"]', '"OPEN": ["fridge", "10"]', "[ ]", "\n", "\0", "\ud800"]
PIECES = st.sampled_from([*SYNTAX, *WRITTEN, *ACTIONS, *NAMES])
SOUP = st.lists(PIECES | st.text(max_size=3), max_size=30).map("".join)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4) | st.sampled_from(NAMES),
    lambda parts: st.lists(parts, max_size=3) | st.dictionaries(st.sampled_from(ACTIONS), parts, max_size=3),
    max_leaves=12,
)
STEPS = st.tuples(
    st.sampled_from(ACTIONS) | st.text(max_size=4),
    st.lists(st.sampled_from(NAMES), max_size=2).map(
        lambda names: [part for name in names for part in name.rsplit(".", 1)]
    ),
)
PLANS = st.lists(STEPS, max_size=12).map(
    lambda steps: "{" + ", ".join(f"{json.dumps(a)}: {json.dumps(names)}" for a, names in steps) + "}"
)


def write_verdict(scorer: ActionSequencingScorer, text: str) -> str:
    return json.dumps(verdict_to_record_fields(scorer.score(text)))


def assert_has_a_verdict(scorer: ActionSequencingScorer, text: str) -> None:
    """Fail unless a text has a complete verdict, equal when scored twice, and an explanation."""
    verdict = scorer.score(text)
    assert (verdict.excluded is None) == (verdict.executable is not None)
    assert verdict.error is None or not verdict.executable
    assert write_verdict(scorer, text) == write_verdict(scorer, text)
    json.dumps(dataclass_to_json(scorer.explain(text)))


TEXTS = SOUP | st.text() | VALUES.map(json.dumps) | VALUES.map(repr) | PLANS


@given(TEXTS)
def test_any_text_has_a_verdict(text: str) -> None:
    assert_has_a_verdict(STRICT, text)


@pytest.fixture
def scorer() -> ActionSequencingScorer:
    """Return the scorer under `strict`. Tests of other protocols override this fixture."""
    return STRICT


@pytest.mark.parametrize(
    "text",
    [
        "\0" * 1000,
        "\ud800\udfff",
        "[" * 100_000,
        "[" * 100_000 + "]" * 100_000,
        "{'a': " * 100_000,
        '{"WALK": ' + "[" * 100_000,
        '{"WALK": ' + "[" * 900 + "]" * 900 + "}",
        '{"WALK": [' + "9" * 100_000 + "]}",
        '{"WALK": ["' + "x" * 900_000 + '"]}',
        "{" * 2_000_000,
    ],
    ids=lambda value: value[:12] if isinstance(value, str) else None,
)
def test_extreme_texts_have_a_verdict(scorer: ActionSequencingScorer, text: str) -> None:
    assert_has_a_verdict(scorer, text)
    assert scorer.score(text).executable is False


def test_a_plan_of_ten_thousand_steps_is_executed(scorer: ActionSequencingScorer) -> None:
    steps = ['"WALK": ["cup"], "GRAB": ["cup"], "WALK": ["bed"], "PUTBACK": ["cup", "bed"]'] * 2_500
    done = "{" + ", ".join(steps) + "}"
    assert scorer.score(done).executable is True
    assert len(scorer.explain(done).steps) == 10_000
    failed = scorer.score(done[:-1] + ', "GRAB": ["milk"]}')
    assert failed.error is not None
    assert failed.error.step == 10_000


@pytest.fixture(scope="module")
def suites(data_store: DataPackStore) -> tuple[Suite, ...]:
    source = Source(data_store)
    return tuple(
        open_suite("virtualhome", Ability.ACTION_SEQUENCING, protocol, source=source)
        for protocol in PROTOCOLS
    )


@pytest.fixture(scope="module")
def answers(data_store: DataPackStore) -> list[tuple[str, str]]:
    """Return an answer with its task id for each task."""
    return made_answers("virtualhome", Ability.ACTION_SEQUENCING, data_store)


@settings(deadline=None)
@given(st.data())
def test_a_damaged_answer_has_a_verdict(
    suites: tuple[Suite, ...], answers: list[tuple[str, str]], data: st.DataObject
) -> None:
    task_id, text = data.draw(st.sampled_from(answers))
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, len(text)))
    damaged = text[:start] + data.draw(SOUP) + text[end:]
    for suite in suites:
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, ActionSequencingScorer)
        assert_has_a_verdict(scorer, damaged)
