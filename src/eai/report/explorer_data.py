"""The explorer's data: records as compact JSON, in which each text stands once.

The page reads it with ``explorer/data.js``, which knows the same keys. Texts are numbers into ``texts``,
steps and operators numbers into ``steps`` and ``operators``; what is empty is left out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from eai.abilities.explanation import StepReport
from eai.abilities.record import Record
from eai.abilities.verdict import Confusion, Json, Verdict
from eai.metrics.breakdown import operators_of, outcome
from eai.metrics.explained import explanation_of
from eai.report.runs import Run, RunKey

VERSION = 1
"""The version of the format."""

Suite: TypeAlias = "tuple[str, str]"
"""Domain and ability."""


@dataclass(frozen=True, slots=True)
class Background:
    """What answers are answers to, where it is at hand.

    Attributes:
        prompts: domain and ability -> task -> prompt.
        operators: domain -> operator -> its definition in the data set.
    """

    prompts: Mapping[Suite, Mapping[str, str]] = field(default_factory=dict)
    operators: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


class ExplorerData:
    """Runs are added one by one; what is kept of them is small."""

    def __init__(self, background: Background) -> None:
        self._background = background
        self._texts: dict[str, int] = {}
        self._steps: dict[str, int] = {}
        self._operators: dict[str, int] = {}
        self._runs: dict[RunKey, Json] = {}
        self._prompts: dict[str, dict[str, Json]] = {}

    def add(self, run: Run) -> None:
        """Add the records of a run."""
        key = run.key
        self._runs[key] = {
            "protocol": key.protocol.value,
            "domain": key.domain,
            "ability": key.ability.value,
            "model": key.model,
            "answers": [self._answer(record) for record in run.records],
        }
        asked = self._background.prompts.get((key.domain, key.ability.value), {})
        kept = self._prompts.setdefault(f"{key.domain}/{key.ability.value}", {})
        for record in run.records:
            prompt = _prompt_of(record) or asked.get(record.task_id)
            if prompt and record.task_id not in kept:
                kept[record.task_id] = [self._text(line) for line in prompt.split("\n")]

    def to_json(self) -> str:
        """Everything as one JSON text that is safe inside a script element."""
        content: Json = {
            "version": VERSION,
            "runs": [self._runs[key] for key in sorted(self._runs, key=lambda key: key.order)],
            "prompts": {suite: lines for suite, lines in self._prompts.items() if lines},
            "gold": {domain: dict(names) for domain, names in self._background.operators.items()},
            "texts": list(self._texts),
            "steps": [json.loads(step) for step in self._steps],
            "operators": [json.loads(operator) for operator in self._operators],
        }
        return for_script(content)

    def _answer(self, record: Record) -> Json:
        verdict = record.verdict
        explanation = explanation_of(verdict)
        details = verdict.details or {}
        return _without_empty(
            {
                "t": self._text(record.task_id),
                "o": outcome(verdict, record.ability).value,
                "x": self._text(verdict.excluded) if verdict.excluded else None,
                "r": self._text(record.response) if record.response else None,
                "e": None if verdict.executable is None else int(verdict.executable),
                "f": self._error(verdict),
                "a": verdict.additional_steps,
                "c": verdict.category and verdict.category.value,
                "g": None if verdict.goals is None else [list(tally) for tally in verdict.goals],
                "n": _counts(verdict),
                "p": verdict.planner and verdict.planner.value,
                "m": list(verdict.repairs),
                "k": details.get("task_categories"),
                "h": self._listed(details.get("hallucinated")),
                "w": [self._text(note) for note in explanation.notes],
                "s": [self._step(step) for step in explanation.steps],
                "G": [[goal.kind, self._text(goal.goal), int(goal.satisfied)] for goal in explanation.goals],
                "q": [self._operator(operator) for operator in operators_of(verdict)],
            }
        )

    def _error(self, verdict: Verdict) -> Json:
        error = verdict.error
        return None if error is None else [error.kind.value, error.step, self._text(error.detail)]

    def _step(self, step: StepReport) -> int:
        """Action, outcome, reason, earlier, facts added, facts removed, number of other changes."""
        packed = [
            self._text(step.action),
            self._text(step.outcome),
            self._text(step.reason),
            self._text(step.earlier),
            [self._text(fact) for fact in step.added],
            [self._text(fact) for fact in step.removed],
            step.hidden_changes,
        ]
        return _number(self._steps, json.dumps(packed))

    def _operator(self, operator: Mapping[str, object]) -> int:
        """Name, status, the sides with matched, additional and missing predicates, and offences."""
        sides = [_side(operator.get(side)) for side in ("precondition", "effect")]
        packed = [operator.get("name"), operator.get("status"), *sides, operator.get("offences") or []]
        return _number(self._operators, json.dumps(packed))

    def _listed(self, value: Json) -> list[int]:
        return [self._text(str(item)) for item in value] if isinstance(value, list | tuple) else []

    def _text(self, text: str) -> int:
        return _number(self._texts, text)


def for_script(content: Json) -> str:
    """JSON in ASCII without ``<``, ``>`` and ``&``, so that no text in it can end a script element."""
    text = json.dumps(content, ensure_ascii=True, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _number(table: dict[str, int], item: str) -> int:
    """The place of an item in a table, into which it is put if it is not there."""
    return table.setdefault(item, len(table))


def _prompt_of(record: Record) -> str | None:
    prompt = (record.verdict.details or {}).get("prompt")
    return prompt if isinstance(prompt, str) else None


def _counts(verdict: Verdict) -> Json:
    """Confusion counts, flat: ``side/category`` for operators."""
    flat: dict[str, Json] = {}
    for name, value in (verdict.counts or {}).items():
        if isinstance(value, Confusion):
            flat[name] = list(value)
        else:
            flat |= {f"{name}/{category}": list(counts) for category, counts in value.items()}
    return flat


def _side(side: object) -> list[list[str]]:
    found = side if isinstance(side, Mapping) else {}
    return [_names(found.get(part)) for part in ("matched", "additional", "missing")]


def _names(value: object) -> list[str]:
    return [str(item) for item in value] if isinstance(value, Sequence) and not isinstance(value, str) else []


def _without_empty(values: Mapping[str, Json]) -> dict[str, Json]:
    return {key: value for key, value in values.items() if value not in (None, [], {}, "")}
