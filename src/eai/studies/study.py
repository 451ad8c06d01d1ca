"""Studies as values: a variation around a benchmark and an ability, and what becomes of records in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError
from eai.benchmarks.registry import title_of
from eai.results.lines import SuiteKey
from eai.results.paper_tables import PaperTable, read_paper_setting
from eai.results.plots import add_title, clip_label
from eai.studies.variation import Variation
from eai.tasks.options import Options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.abilities.protocol import Ability, Protocol
    from eai.base.json_value import Json
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record
    from eai.results.runs import RunKey
    from eai.results.table import Table
    from eai.studies.records import Records

Figures: TypeAlias = "Iterable[tuple[str, Figure | None]]"
"""Figures by the names of their files, drawn one after the other; None where there is nothing to draw."""


@dataclass(frozen=True, slots=True)
class Analysis:
    """Tables and figures of records that belong together.

    Attributes:
        tables: the tables.
        figures: drawn when they are asked for, which needs an extra.
        remarks: what a reader must know besides, each a sentence.
        folder: where they are written, below the folder of the results; in that itself if empty.
        shown: tables for the screen, whose cells are texts; one line says what was written if there are none.
        facts: further output for programs.
    """

    tables: Sequence[Table]
    figures: Figures = ()
    remarks: Sequence[str] = ()
    folder: str = ""
    shown: Sequence[Table] = ()
    facts: Mapping[str, Json] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Study:
    """A variation around a benchmark and an ability: what a run can choose, and what its records tell.

    It is registered by an entry point of the group ``eai.studies`` (`eai.studies.registry`). What it needs to
    analyse records is imported by ``analyze``, so that its options cost nothing.

    Attributes:
        name: of its analysis and of the files that this writes.
        title: a few words on what varies, and for which questions.
        options: what a run can choose; the defaults are those of a run without the study.
        section: what its options are called in a run's specification, if not by its name.
        choices: what its analysis can be asked for.
        analyze: makes its tables and figures of records; figures are drawn from more than tables print, so
            that one function makes both.
        summarize: returns what records say of an answer besides their options: takes a record, its suite, and
            the metadata of its question.
        together: whether it is one of those that ``eai analyze all`` makes of the same records.
    """

    name: str
    title: str
    options: type[Variation] = Variation
    section: str = ""
    choices: type[Options] = Options
    analyze: Callable[[Records, Any], Iterator[Analysis]] | None = None
    summarize: Callable[[Record, Suite, Mapping[str, Any]], Mapping[str, Json]] | None = None
    together: bool = False

    @property
    def key(self) -> str:
        """The name of its section in a run's specification."""
        return self.section or self.name


def suite_title(suite: SuiteKey) -> str:
    """A suite in headings, with its benchmark as that spells itself."""
    return str(suite._replace(domain=title_of(suite.domain)))


def of_suite(suite: SuiteKey, name: str, figure: Figure | None) -> tuple[str, Figure | None]:
    """A figure with the suite that it is of for a title, by the name of its files."""
    if figure is not None:
        add_title(figure, suite_title(suite))
    return f"{name}-{suite.file_name}", figure


def of_run(key: RunKey, name: str, figure: Figure | None) -> tuple[str, Figure | None]:
    """A figure with the suite and the model that it is of for a title, by the name of its files."""
    if figure is not None:
        add_title(figure, f"{suite_title(key.suite)}, {clip_label(key.model)}")
    return name, figure


def paper_remarks(papers: Iterable[PaperTable], protocol: Protocol) -> list[str]:
    """Remarks on figures of the paper that stand beside those of records of a protocol."""
    on_columns = (paper.notes.get(("", column), ()) for paper in papers for column in paper.columns)
    remarks = [note for notes in on_columns for note in notes]
    if protocol.value != read_paper_setting().protocol:
        remarks.append(f"These records are of protocol {protocol.value}, the paper's figures are not.")
    return list(dict.fromkeys(remarks))


def metric_of(ability: Ability, chosen: str | None) -> str:
    """The chosen metric of an ability's main table; the first of it if None.

    Raises:
        InputError: there is no such metric.
    """
    from eai.abilities.declaration import declaration_of

    known = declaration_of(ability).overview_headings
    if chosen is not None and chosen not in known:
        raise InputError(f"metric={chosen}: expected one of {', '.join(known)}")
    return chosen or next(iter(known))


def several(given: object) -> object:
    """The values that a text names, separated by commas; for options that have several."""
    return tuple(given.split(",")) if isinstance(given, str) else given
