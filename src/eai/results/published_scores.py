"""Scores that come with the package: of the published answers of the paper's models, and of null models.

The paper has no numbers of the protocol that its models' answers are scored under here. Null models decide
nothing: what they earn is the floor on which every other number stands. The tables hold numbers only;
``tools/published_scores.py`` writes them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from pydantic import TypeAdapter

from eai.abilities.responses import file_name
from eai.abilities.verdict import Share
from eai.results.coverage import Coverage
from eai.results.rate import Rate, total

TABLE = "published_strict.json"
"""The name of the table among those of the paper."""

NULL_MODELS = {
    "eai/copy": "copies what the question says",
    "eai/empty": "answers nothing, in the form asked for",
    "eai/lookup": "answers as another task of the data set is answered, the most similar one",
    "eai/random": "answers at random what is well-formed",
}
"""The models that decide nothing, and what they do."""

SCHEMA = 1
"""The version of its format."""


@dataclass(frozen=True, slots=True)
class _PublishedAnswers:
    """The scores of a model's published answers to a suite.

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
    models: Mapping[str, _PublishedAnswers]
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


def is_null_model(name: str) -> bool:
    """Whether records of this model's name are of a null model, which is no model to compare others with."""
    return name in {file_name(model) for model in NULL_MODELS}


@cache
def published_scores() -> PublishedScores:
    """The table of the paper's models."""
    return TypeAdapter(PublishedScores).validate_json(_content(TABLE))


@cache
def null_scores(protocol: str) -> PublishedScores:
    """The table of the null models under a protocol."""
    return TypeAdapter(PublishedScores).validate_json(_content(null_table(protocol)))


def null_table(protocol: str) -> str:
    """The name of the file of `null_scores`."""
    return f"null_models_{protocol}.json"


@cache
def published_scores_sha256() -> str:
    """Digest of the file of `published_scores`."""
    return hashlib.sha256(_content(TABLE)).hexdigest()


def _content(table: str) -> bytes:
    return (resources.files("eai.results") / "paper" / table).read_bytes()
