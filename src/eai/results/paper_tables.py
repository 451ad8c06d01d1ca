"""The paper's tables as data, with what a reader of them must know.

Figures are in percent, as printed. Columns have the names of our metrics; models have one name each, though
the paper spells some in several ways. Notes say where public data cannot give a figure (``notes.toml``);
where two tables of the paper contradict each other is computed from the tables themselves.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from itertools import product
from typing import NamedTuple

from pydantic import TypeAdapter

from eai.base.files import parse_toml, to_file_name
from eai.base.grouping import group_pairs
from eai.results.coverage import Coverage
from eai.results.rate import Rate, total
from eai.tasks.share import Share


class PaperColumn(NamedTuple):
    """The metric that a column shows; the average over all abilities has an empty ability."""

    ability: str
    metric: str
    domain: str


@dataclass(frozen=True, slots=True)
class PaperTable:
    """One table of the paper.

    Attributes:
        name: the name of its file here.
        rows: model -> column -> figure in percent, None where the paper has none; in the paper's order.
        notes: model and column -> remarks on the figure, a sentence or two each; on all of a column where the
            model is empty.
    """

    name: str
    title: str
    columns: tuple[PaperColumn, ...]
    rows: Mapping[str, Mapping[PaperColumn, float | None]]
    notes: Mapping[tuple[str, PaperColumn], Sequence[str]] = field(default_factory=dict)

    def figure(self, model: str, column: PaperColumn) -> float | None:
        """A figure in percent, or None if the table does not have it."""
        return self.rows.get(model, {}).get(column)


@dataclass(frozen=True, slots=True)
class _PaperSetting:
    """The setting of the paper's numbers (``setting.toml``).

    Attributes:
        protocol: the protocol whose numbers are the same quantities.
        tables: a report's table -> the paper's tables with the same columns, in order of preference.
        others: the tables of a few models, or of other ways to ask -> a report's table with the same columns.
        same_quantity: those of the others whose figures should be those of the full tables.
        other_tasks: those of the others that no run is to be set beside.
    """

    protocol: str
    tables: Mapping[str, tuple[str, ...]]
    others: Mapping[str, str]
    same_quantity: tuple[str, ...]
    other_tasks: tuple[str, ...]

    @property
    def full_tables(self) -> tuple[str, ...]:
        """The tables of all 18 models, the overview first."""
        return tuple(dict.fromkeys(name for names in self.tables.values() for name in names))


@cache
def read_paper_setting() -> _PaperSetting:
    """The paper's protocol, domains and tables."""
    return TypeAdapter(_PaperSetting).validate_python(parse_toml(_text("setting.toml")))


def read_paper_table(name: str) -> PaperTable:
    """One of the full tables or of the others, with its notes."""
    table = _read_table(name)
    return replace(table, notes=group_pairs((*_written_notes(table), *_contradictions(table))))


@cache
def read_paper_models() -> Mapping[str, str]:
    """The name of a published response file -> the paper's name of the model."""
    return parse_toml(_text("models.toml"))


@cache
def _read_table(name: str) -> PaperTable:
    """A table without its notes."""
    found = json.loads(_text(f"{name}.json"))
    columns = tuple(PaperColumn(*text.split("/")) for text in found["columns"])
    rows = {model: dict(zip(columns, row, strict=True)) for model, row in found["rows"].items()}
    return PaperTable(name, found["title"], columns, rows)


def _text(name: str) -> str:
    return _content(name).decode()


def _written_notes(table: PaperTable) -> Iterator[tuple[tuple[str, PaperColumn], str]]:
    """The notes of ``notes.toml`` on a table."""
    for note in parse_toml(_text("notes.toml"))["note"]:
        if table.name in _listed(note["table"]):
            told = {key: note[key] for key in PaperColumn._fields if key in note}
            for column in table.columns:
                if told.items() <= column._asdict().items():
                    yield from (((model, column), note["text"]) for model in _listed(note.get("model", "")))


def _listed(value: str | list[str]) -> list[str]:
    return [value] if isinstance(value, str) else value


def _contradictions(table: PaperTable) -> Iterator[tuple[tuple[str, PaperColumn], str]]:
    """Cells for which another of the full tables prints another figure."""
    full = read_paper_setting().full_tables
    if table.name not in (*full, *read_paper_setting().same_quantity):
        return
    for other in [_read_table(name) for name in full if name != table.name]:
        for model, column in product(table.rows, table.columns):
            printed = other.figure(model, column)
            if column in other.columns and model in other.rows and printed != table.figure(model, column):
                yield (model, column), f"The table “{other.title}” prints {printed}."


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
class _PublishedScores:
    """The table.

    Attributes:
        schema: the version of its format.
        protocol: what the answers were scored under.
        suites: domain, slash, ability -> its suite.
    """

    schema: int
    protocol: str
    suites: Mapping[str, PublishedSuite]


def is_null_model(name: str) -> bool:
    """Whether records of this model's name are of a null model, which is no model to compare others with."""
    return name in {to_file_name(model) for model in NULL_MODELS}


@cache
def read_published_scores(protocol: str) -> _PublishedScores:
    """Return the scores of the public answers of the paper's models under a protocol."""
    return TypeAdapter(_PublishedScores).validate_json(_content(published_file_name(protocol)))


def published_file_name(protocol: str) -> str:
    """Return the name of the file of `published_scores`."""
    return f"published_{protocol}.json"


@cache
def read_null_scores(protocol: str) -> _PublishedScores:
    """The table of the null models under a protocol."""
    return TypeAdapter(_PublishedScores).validate_json(_content(null_file_name(protocol)))


def null_file_name(protocol: str) -> str:
    """The name of the file of `null_scores`."""
    return f"null_models_{protocol}.json"


@cache
def hash_published_scores(protocol: str) -> str:
    """Return the digest of the file of `published_scores`."""
    return hashlib.sha256(_content(published_file_name(protocol))).hexdigest()


def _content(table: str) -> bytes:
    return (resources.files("eai.results") / "paper" / table).read_bytes()
