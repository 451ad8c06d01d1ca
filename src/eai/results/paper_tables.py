"""The paper's tables as data, with what a reader of them must know.

Figures are in percent, as printed. Columns have the names of our metrics; models have one name each, though
the paper spells some in several ways. Notes say where public data cannot give a figure (``notes.toml``);
where two tables of the paper contradict each other is computed from the tables themselves.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import NamedTuple

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

OTHER_TABLES = (
    "transition_modeling_summary",
    "human",
    "replanning",
    "replanning_prose",
    "replanning_stochastic",
    "pipeline_action_sequencing",
    "pipeline_subgoal_decomposition",
)
"""The tables of a few models, or of other ways to ask."""

_SAME_QUANTITY = ("transition_modeling_summary", "replanning")
"""Those of `OTHER_TABLES` whose figures should be those of the full tables, row by row of the same name."""

_FOLDER = "paper"


class PaperColumn(NamedTuple):
    """The metric that a column shows; the average over all abilities has an empty ability."""

    ability: str
    metric: str
    domain: str


@dataclass(frozen=True, slots=True)
class _PaperNote:
    """A remark on some cells.

    Attributes:
        text: one or two sentences.
        models: the rows it is on; all if empty.
        columns: the columns it is on.
    """

    text: str
    models: tuple[str, ...]
    columns: tuple[PaperColumn, ...]

    def is_on(self, model: str, column: PaperColumn) -> bool:
        """Whether it is on a cell."""
        return column in self.columns and (not self.models or model in self.models)


@dataclass(frozen=True, slots=True)
class PaperTable:
    """One table of the paper.

    Attributes:
        name: the name of its file here.
        label: the label of the table in the paper's source.
        rows: model -> figures in percent, None where the paper has none; in the paper's order.
    """

    name: str
    label: str
    title: str
    columns: tuple[PaperColumn, ...]
    rows: Mapping[str, tuple[float | None, ...]]
    notes: tuple[_PaperNote, ...]

    def figure(self, model: str, column: PaperColumn) -> float | None:
        """A figure in percent, or None if the table does not have it."""
        if model not in self.rows or column not in self.columns:
            return None
        return self.rows[model][self.columns.index(column)]


@dataclass(frozen=True, slots=True)
class _PaperSetting:
    """The setting of the paper's numbers (``setting.toml``).

    Attributes:
        protocol: the protocol whose numbers are the same quantities.
        domains: the name of a domain in records -> its name in the paper, in the paper's order.
        tables: a report's table -> the paper's tables with the same columns, in order of preference.
    """

    protocol: str
    domains: Mapping[str, str]
    tables: Mapping[str, tuple[str, ...]]

    @property
    def full_tables(self) -> tuple[str, ...]:
        """The tables of all 18 models, the overview first."""
        return tuple(dict.fromkeys(name for names in self.tables.values() for name in names))


@cache
def paper_setting() -> _PaperSetting:
    """The paper's protocol, domains and tables."""
    found = tomllib.loads(_text("setting.toml"))
    tables = {name: tuple(papers) for name, papers in found["tables"].items()}
    return _PaperSetting(found["protocol"], found["domains"], tables)


def paper_table(name: str) -> PaperTable:
    """One of the full tables or of `OTHER_TABLES`, with its notes."""
    label, title, columns, rows = _read_table(name)
    notes = (*_written_notes(name, columns), *_contradictions(name))
    return PaperTable(name, label, title, columns, rows, notes)


@cache
def paper_models() -> Mapping[str, str]:
    """The name of a published response file -> the paper's name of the model."""
    found = tomllib.loads(_text("models.toml"))
    return {file: str(name) for file, name in found.items()}


class _Content(NamedTuple):
    label: str
    title: str
    columns: tuple[PaperColumn, ...]
    rows: Mapping[str, tuple[float | None, ...]]


@cache
def _read_table(name: str) -> _Content:
    found = json.loads(_text(f"{name}.json"))
    columns = tuple(PaperColumn(*text.split("/")) for text in found["columns"])
    return _Content(
        found["label"], found["title"], columns, {model: tuple(row) for model, row in found["rows"].items()}
    )


def _text(name: str) -> str:
    return (resources.files("eai.results") / _FOLDER / name).read_text(encoding="utf-8")


def _written_notes(name: str, columns: Sequence[PaperColumn]) -> Iterator[_PaperNote]:
    """The notes of ``notes.toml`` on a table."""
    for note in tomllib.loads(_text("notes.toml"))["note"]:
        if name in _listed(note["table"]):
            met = tuple(
                column
                for column in columns
                if all(getattr(column, key) == note[key] for key in PaperColumn._fields if key in note)
            )
            yield _PaperNote(note["text"], _listed(note.get("model", [])), met)


def _listed(value: str | list[str]) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value)


def _contradictions(name: str) -> Iterator[_PaperNote]:
    """Cells for which another of the full tables prints another figure."""
    full = paper_setting().full_tables
    if name not in (*full, *_SAME_QUANTITY):
        return
    ours = _read_table(name)
    for other in full:
        theirs = _read_table(other)
        shared = [column for column in ours.columns if column in theirs.columns and other != name]
        for model in [model for model in ours.rows if model in theirs.rows]:
            for column in shared:
                printed = theirs.rows[model][theirs.columns.index(column)]
                if printed != ours.rows[model][ours.columns.index(column)]:
                    yield _PaperNote(f"The table “{theirs.title}” prints {printed}.", (model,), (column,))
