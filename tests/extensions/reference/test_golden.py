"""Verdicts of `eai-1.0.5` on damaged gold answers stay as they are.

Other tests compare verdicts on published answers with those of the reference package, if these are at hand.
The golden file has the verdicts of a version that agreed with all of these.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from eai.abilities.protocol import Ability, Protocol
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import make_noisy_answer, make_random_generator
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.codec import verdict_to_record_fields
from eai.tasks.source import Source
from golden_files import assert_golden
from suites import SUITES, answer_book

EVERY = 3
"""Step in which the tasks of a suite are gone through."""

NOISE = 0.2
"""Share of the parts of an answer that are corrupted."""

FIELDS = (
    *("excluded_reason", "executable", "success", "additional_steps", "category", "counts"),
    *("goals_satisfied", "errors", "predicted", "hallucinated", "ill_formed", "operators", "literals"),
)
"""The fields of verdicts that are compared, besides the kind and the step of the error."""


def test_verdicts_on_damaged_answers_are_those_of_the_golden_file(data_store: DataPackStore) -> None:
    lines = [line for name, ability in SUITES for line in suite_lines(name, ability, data_store)]
    assert_golden(Path(__file__).with_name("golden_verdicts.txt"), lines)


def suite_lines(name: str, ability: Ability, store: DataPackStore) -> Iterator[str]:
    """Yield digests of a suite's answers and of the verdicts on them, and how many ended with each error."""
    source = Source(store, planner=PlannerChoice.NONE)
    suite = open_suite(name, ability, Protocol("eai-1.0.5"), source=source)
    answers = list(damaged_answers(name, ability, store))
    suite = suite.choose_suite_for_answers([text for _, text in answers])
    verdicts = [
        verdict_fields(verdict_to_record_fields(suite.score(task_id, text))) for task_id, text in answers
    ]
    kinds = Counter(str(verdict["error"][0]) for verdict in verdicts if verdict["error"])
    yield f"{name}/{ability.value}: {len(answers)} answers {digest(answers)}"
    right = sum(verdict["success"] is True for verdict in verdicts)
    yield f"  verdicts {digest(verdicts)}" + (f", {right} right" if right else "")
    yield from (f"  {number} {kind}" for kind, number in sorted(kinds.items()))


def damaged_answers(name: str, ability: Ability, store: DataPackStore) -> Iterator[tuple[str, str]]:
    """Yield a gold answer, one with corrupted parts and one that is cut off, for some tasks."""
    book = answer_book(name, ability, store)
    for task_id in list(book)[::EVERY]:
        gold = book[task_id].text
        yield task_id, gold
        yield task_id, make_noisy_answer(book, task_id, NOISE, "golden").text
        yield task_id, gold[: make_random_generator("golden", task_id).randrange(len(gold))]


def verdict_fields(fields: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a verdict that are compared."""
    error = fields.get("error") or {}
    kept = {name: fields.get(name) for name in FIELDS}
    return {**kept, "error": [error.get("kind"), error.get("step")] if error else None}


def digest(values: object) -> str:
    return hashlib.sha256(json.dumps(values, default=str).encode()).hexdigest()[:16]
