"""The published answers of the paper's models scored by us, where the paper has no numbers of a protocol.

The table holds numbers only. ``tools/published_scores.py`` writes it from files of answers.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from pydantic import TypeAdapter

from eai.abilities.share import Share
from eai.metrics.coverage import Coverage
from eai.metrics.rate import Rate, total

TABLE = "published_strict.json"
"""The name of the table among those of the paper."""

SCHEMA = 1
"""The version of its format."""


@dataclass(frozen=True, slots=True)
class PublishedAnswers:
    """What a model's published answers to a suite come to.

    Attributes:
        answers_sha256: digest of the answers, by which they can be known again.
        answered: how many tasks have an answer.
        rates: numerator and denominator of each metric of the suite, in order.
    """

    answers_sha256: str
    answered: int
    rates: tuple[Share, ...]


@dataclass(frozen=True, slots=True)
class PublishedSuite:
    """A suite of the table.

    Attributes:
        data_sha256: digest of the data that the answers were scored against.
        tasks: how many tasks the suite has.
        metrics: the names of the metrics.
        models: by the paper's name of the model, in the order of the names.
        notes: what a reader of the numbers must know, a sentence or two each.
    """

    data_sha256: str
    tasks: int
    metrics: tuple[str, ...]
    models: Mapping[str, PublishedAnswers]
    notes: tuple[str, ...] = ()

    def rates(self, model: str) -> Mapping[str, Rate]:
        """The rates of a model's answers, by metric."""
        return total([dict(zip(self.metrics, self.models[model].rates, strict=True))])

    def coverage(self, model: str) -> Coverage:
        """How much of the suite the model's answers cover; what they lack counts as failures."""
        answered = self.models[model].answered
        return Coverage(self.tasks, answered, self.tasks - answered, tasks=self.tasks)


@dataclass(frozen=True, slots=True)
class PublishedScores:
    """The table.

    Attributes:
        schema: the version of its format.
        protocol: what the answers were scored under.
        suites: domain, slash, ability -> its suite.
    """

    schema: int
    protocol: str
    suites: Mapping[str, PublishedSuite]

    def suite(self, domain: str, ability: str) -> PublishedSuite | None:
        """A suite, or None if the table does not have it."""
        return self.suites.get(f"{domain}/{ability}")


@cache
def published_scores() -> PublishedScores:
    """The table."""
    return TypeAdapter(PublishedScores).validate_json(_content())


@cache
def published_scores_sha256() -> str:
    """Digest of the table's file."""
    return hashlib.sha256(_content()).hexdigest()


def _content() -> bytes:
    return (resources.files("eai.metrics") / "paper" / TABLE).read_bytes()
