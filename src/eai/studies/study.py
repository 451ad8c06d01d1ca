"""Define studies: the options that a study adds to runs, and the analysis of the runs' stored verdicts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError
from eai.benchmarks.registry import get_title
from eai.results.lines import SuiteKey
from eai.results.paper_tables import PaperTable, read_paper_protocol_and_tables
from eai.results.plots import add_title, clip_label
from eai.studies.variation import VariationOptions
from eai.tasks.options import Options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.abilities.protocol import Ability, Protocol
    from eai.base.json_value import Json
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record
    from eai.results.runs import RunKey
    from eai.results.table import Table
    from eai.studies.records import StudyRecords

Figures: TypeAlias = "Iterable[tuple[str, Figure | None]]"
"""File names with figures, drawn one after the other. A figure without anything to show is None."""


@dataclass(frozen=True, slots=True)
class Analysis:
    """Tables and figures of records (stored verdicts on answers) that are analysed together.

    Attributes:
        tables: the tables.
        figures: the figures, drawn when they are iterated over; drawing needs an optional dependency.
        remarks: sentences that a reader of the tables must know.
        folder: subfolder of the output in the folder of the results; empty for the folder of the results.
        screen_tables: tables for the screen; without such tables, the screen shows only the names of the
            output.
        facts: further values for the JSON output, by name.
        pages: HTML pages, by file name.
    """

    tables: Sequence[Table]
    figures: Figures = ()
    remarks: Sequence[str] = ()
    folder: str = ""
    screen_tables: Sequence[Table] = ()
    facts: Mapping[str, Json] = field(default_factory=dict)
    pages: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Study:
    """A study: options that vary a run, and an analysis of records (stored verdicts on answers).

    A study is registered by an entry point of the group ``eai.studies`` (`eai.studies.registry`). ``analyze``
    imports the modules for the analysis, so that reading the options stays fast.

    Attributes:
        name: name of the analysis, of its output files, and of the options in a run's specification.
        title: a few words on the varied option, and on the question that the analysis answers.
        options: the options of a run; with the defaults, the study changes nothing.
        choices: the options of the analysis.
        analyze: makes tables and figures from records. One function makes tables and figures, because figures
            use data that tables do not print.
        summarize: returns the summary of an answer that a record stores in addition to the options. Its
            arguments are the record, the record's suite, and the metadata of the question.
        included_in_all: whether ``eai analyze all`` runs the analysis.
    """

    name: str
    title: str
    options: type[VariationOptions] = VariationOptions
    choices: type[Options] = Options
    analyze: Callable[[StudyRecords, Any], Iterator[Analysis]] | None = None
    summarize: Callable[[Record, Suite, Mapping[str, Any]], Mapping[str, Json]] | None = None
    included_in_all: bool = False


def format_suite_heading(suite: SuiteKey) -> str:
    """Return the heading of a suite, with the title of its benchmark."""
    return str(suite._replace(domain=get_title(suite.domain)))


def make_file_name_and_titled_suite_figure(
    suite: SuiteKey, file_name_prefix: str, figure: Figure | None
) -> tuple[str, Figure | None]:
    """Return the file name of a figure of a suite, and the figure with the suite's title.

    The file name is the given name and the name of the suite. A missing figure, None, stays None.
    """
    if figure is not None:
        add_title(figure, format_suite_heading(suite))
    return f"{file_name_prefix}-{suite.suite_name_for_file_names}", figure


def make_file_name_and_titled_run_figure(
    key: RunKey, file_name: str, figure: Figure | None
) -> tuple[str, Figure | None]:
    """Return the file name of a figure of a run, and the figure with a title of suite and model.

    The file name is the given name. A missing figure, None, stays None.
    """
    if figure is not None:
        add_title(figure, f"{format_suite_heading(key.suite)}, {clip_label(key.model)}")
    return file_name, figure


def make_remarks_on_comparison_with_paper(
    printed_tables: Iterable[PaperTable], protocol: Protocol
) -> list[str]:
    """Return remarks for readers who compare runs, scored by a protocol (set of rules), with the paper."""
    on_columns = (
        printed_table.notes.get(("", column), ())
        for printed_table in printed_tables
        for column in printed_table.columns
    )
    remarks = [note for notes in on_columns for note in notes]
    if protocol.value != read_paper_protocol_and_tables().protocol:
        remarks.append(f"These records are of protocol {protocol.value}, the paper's figures are not.")
    return list(dict.fromkeys(remarks))


def choose_metric(ability: Ability, chosen: str | None) -> str:
    """Return the chosen metric of an ability's main table; the table's first metric if the choice is None.

    Raises:
        InputError: the table has no such metric.
    """
    from eai.abilities.declaration import get_declaration

    metrics = get_declaration(ability).overview_headings
    if chosen is not None and chosen not in metrics:
        raise InputError(f"metric={chosen}: expected one of {', '.join(metrics)}")
    return chosen or next(iter(metrics))


def split_option_at_commas(value: object) -> object:
    """Return the values of an option that takes several values. A text is split at its commas."""
    return tuple(value.split(",")) if isinstance(value, str) else value
