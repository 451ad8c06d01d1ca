"""Reads the paper's tables as data, with notes for readers.

Figures are in percent, as printed. Columns have the names of our metrics. Each model has one name, although
the paper spells some in several ways. Notes say which figures public data cannot reproduce (``notes.toml``).
Contradictions between two tables of the paper are computed from the tables.
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

from eai.base.files import parse_toml, to_model_name
from eai.base.grouping import group_pairs
from eai.results.coverage import TaskCoverageByAnswers
from eai.results.rate import Rate, compute_rates
from eai.tasks.share import Share


class PaperColumn(NamedTuple):
    """The ability and metric of a column; the ability is empty for the average over all abilities."""

    ability: str
    metric: str
    domain: str


@dataclass(frozen=True, slots=True)
class PaperTable:
    """One table of the paper.

    Attributes:
        name: name of its file in the folder ``paper``.
        rows: mapping from each model to a mapping from columns to rates in percent, None for an empty
            cell; in the paper's order.
        notes: mapping from pairs of a model and a column to remarks on the rate, a sentence or two each.
            The model is empty for remarks on a whole column.
    """

    name: str
    title: str
    columns: tuple[PaperColumn, ...]
    rows: Mapping[str, Mapping[PaperColumn, float | None]]
    notes: Mapping[tuple[str, PaperColumn], Sequence[str]] = field(default_factory=dict)

    def find_printed_number(self, model: str, column: PaperColumn) -> float | None:
        """Return a rate that the paper printed, in percent, or None if the table does not have it."""
        return self.rows.get(model, {}).get(column)


@dataclass(frozen=True, slots=True)
class _PaperProtocolAndTables:
    """The protocol (scoring rules) of the paper's numbers, and the paper's tables (``setting.toml``).

    Attributes:
        protocol: name of the rules under which our metrics can be compared with the paper's numbers.
        tables: mapping from each table of our reports to the names of the paper's tables of all 18 models
            with the same columns. If several of the paper's tables have a cell, the first table counts.
        others: mapping from the name of each further table of the paper to our table with the same columns.
            Further tables have only some models, or other kinds of questions.
        same_quantity: those further tables whose numbers repeat numbers of the tables of all models. Notes
            list the repeated numbers that differ.
        other_tasks: those further tables that cannot be compared with runs, because they have other tasks, or
            because possible actions fail.
    """

    protocol: str
    tables: Mapping[str, tuple[str, ...]]
    others: Mapping[str, str]
    same_quantity: tuple[str, ...]
    other_tasks: tuple[str, ...]

    @property
    def names_of_tables_with_all_models(self) -> tuple[str, ...]:
        """Names of the tables of all 18 models, the overview first."""
        return tuple(dict.fromkeys(name for names in self.tables.values() for name in names))


@cache
def read_paper_protocol_and_tables() -> _PaperProtocolAndTables:
    """Return the protocol (scoring rules) for comparisons with the paper, and the names of its tables."""
    return TypeAdapter(_PaperProtocolAndTables).validate_python(parse_toml(_read_paper_text("setting.toml")))


def read_paper_table(name: str) -> PaperTable:
    """Return one table of the paper with its notes."""
    table = _read_table(name)
    return replace(
        table,
        notes=group_pairs(
            (*_read_footnotes_of_table_cells(table), *_find_cells_contradicted_by_other_tables(table))
        ),
    )


@cache
def map_files_to_paper_models() -> Mapping[str, str]:
    """Return a mapping from the names of published response files to the paper's names of their models."""
    return parse_toml(_read_paper_text("models.toml"))


@cache
def _read_table(name: str) -> PaperTable:
    content = json.loads(_read_paper_text(f"{name}.json"))
    columns = tuple(PaperColumn(*text.split("/")) for text in content["columns"])
    rows = {model: dict(zip(columns, row, strict=True)) for model, row in content["rows"].items()}
    return PaperTable(name, content["title"], columns, rows)


def _read_paper_text(name: str) -> str:
    return _read_paper_file(name).decode()


def _read_footnotes_of_table_cells(table: PaperTable) -> Iterator[tuple[tuple[str, PaperColumn], str]]:
    for note in parse_toml(_read_paper_text("notes.toml"))["note"]:
        if table.name in _to_list(note["table"]):
            fields = {key: note[key] for key in PaperColumn._fields if key in note}
            for column in table.columns:
                if fields.items() <= column._asdict().items():
                    yield from (((model, column), note["text"]) for model in _to_list(note.get("model", "")))


def _to_list(value: str | list[str]) -> list[str]:
    return [value] if isinstance(value, str) else value


def _find_cells_contradicted_by_other_tables(
    table: PaperTable,
) -> Iterator[tuple[tuple[str, PaperColumn], str]]:
    """Yield a note for each cell whose rate differs between two of the paper's tables of all 18 models."""
    full = read_paper_protocol_and_tables().names_of_tables_with_all_models
    if table.name not in (*full, *read_paper_protocol_and_tables().same_quantity):
        return
    for other in [_read_table(name) for name in full if name != table.name]:
        for model, column in product(table.rows, table.columns):
            printed = other.find_printed_number(model, column)
            if (
                column in other.columns
                and model in other.rows
                and printed != table.find_printed_number(model, column)
            ):
                yield (model, column), f"The table “{other.title}” prints {printed}."


NULL_MODELS = {
    "eai/copy": "copies what the question says",
    "eai/empty": "answers nothing, in the form asked for",
    "eai/lookup": "answers as another task of the data set is answered, the most similar one",
    "eai/random": "answers at random what is well-formed",
}
"""Mapping from models that do not try to solve tasks to descriptions of their answers."""

NULL_AGENTS = {
    "eai/blind": "acts at random, also impossibly",
    "eai/novel": "acts at random, towards new states",
    "eai/random": NULL_MODELS["eai/random"],
}
"""Mapping from models that act without knowing the goals to descriptions of their actions."""

SCHEMA = 1
"""Version of the format of published scores."""


@dataclass(frozen=True, slots=True)
class _PublishedAnswers:
    """The scores of a model's published answers to a suite (an ability in a benchmark).

    Attributes:
        answers_sha256: digest of the answers, to recognise them.
        answered: number of tasks with an answer.
        rates: numerator and denominator of each metric of the suite, in order.
    """

    answers_sha256: str
    answered: int
    rates: tuple[Share, ...]


@dataclass(frozen=True, slots=True)
class ScoresOfPublishedAnswers:
    """The scores of published answers to one suite (an ability in a benchmark).

    Attributes:
        data_sha256: digest of the data that the answers were scored against.
        tasks: number of tasks of the suite.
        metrics: names of the metrics.
        models: mapping from the paper's name of each model to its answers, sorted by name.
        notes: notes for readers of the numbers.
    """

    data_sha256: str
    tasks: int
    metrics: tuple[str, ...]
    models: Mapping[str, _PublishedAnswers]
    notes: tuple[str, ...] = ()

    def find_rates(self, model: str) -> Mapping[str, Rate]:
        """Return a mapping from names of metrics to the rates that a model's answers reach."""
        return compute_rates([dict(zip(self.metrics, self.models[model].rates, strict=True))])

    def find_coverage(self, model: str) -> TaskCoverageByAnswers:
        """Return how many tasks of the suite a model answered; the other tasks count as failures."""
        answered = self.models[model].answered
        return TaskCoverageByAnswers(self.tasks, answered, self.tasks - answered, tasks=self.tasks)


@dataclass(frozen=True, slots=True)
class _PublishedScores:
    """The scores of published answers to all suites. A suite has the tasks of a benchmark for one ability.

    Attributes:
        schema: version of the format.
        protocol: rules by which the answers were scored.
        suites: the scores by ``domain/ability``.
    """

    schema: int
    protocol: str
    suites: Mapping[str, ScoresOfPublishedAnswers]


def is_trivial_baseline(name: str) -> bool:
    """Return whether a name belongs to a null model. Null models ignore the task and are not ranked."""
    return to_model_name(name) in NULL_MODELS | NULL_AGENTS


@cache
def read_published_scores(protocol: str) -> _PublishedScores:
    """Return the scores of the public answers of the paper's models under a protocol (rules of scoring)."""
    return TypeAdapter(_PublishedScores).validate_json(
        _read_paper_file(format_published_scores_file_name(protocol))
    )


def format_published_scores_file_name(protocol: str) -> str:
    """Return the name of the file with the scores of the paper's public answers under a protocol (rules)."""
    return f"published_{protocol}.json"


@cache
def read_trivial_baseline_scores(protocol: str) -> _PublishedScores:
    """Return the scores of models that do not try to solve tasks, under a protocol (scoring rules)."""
    return TypeAdapter(_PublishedScores).validate_json(
        _read_paper_file(format_trivial_baselines_file_name(protocol))
    )


def format_trivial_baselines_file_name(protocol: str) -> str:
    """Return the name of the file with the scores of the null models under a protocol (scoring rules)."""
    return f"null_models_{protocol}.json"


@cache
def hash_published_scores(protocol: str) -> str:
    """Return the SHA-256 digest of the file that `format_published_scores_file_name` names."""
    return hashlib.sha256(_read_paper_file(format_published_scores_file_name(protocol))).hexdigest()


def _read_paper_file(table: str) -> bytes:
    return (resources.files("eai.results") / "paper" / table).read_bytes()
