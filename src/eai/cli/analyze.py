"""``eai analyze``: make tables and plots of a study from records (scored answers)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer
from pydantic import BeforeValidator

from eai.base.errors import EaiError, InputError, did_you_mean, require_extra
from eai.base.files import raise_write_errors_as_input_errors
from eai.base.json_value import Json
from eai.cli import options
from eai.cli.console import (
    format_count,
    get_error_console,
    get_output_console,
    print_markdown,
    print_note,
    print_result,
    print_result_line,
)
from eai.cli.options import OUTPUT, AsJson, DataFolder, make_flag
from eai.cli.progress import show_scoring_progress
from eai.results.lines import SUITE, TABLES
from eai.results.plots import FORMATS, parse_formats, use_plot_style, write_figure
from eai.results.table import Table
from eai.results.table_files import format_lines_as_csv, write_files, write_parquet, write_tables
from eai.results.terminal import print_table
from eai.studies.records import StudyRecords
from eai.studies.registry import find_study, list_study_names
from eai.studies.study import Analysis, Figures, Study, split_option_at_commas
from eai.tasks.options import Options

ALL, TABLE = "all", "table"
"""Values for the name of a study (an analysis): `all` runs several studies, `table` writes tidy tables."""


class _TableFileOptions(Options):
    """Options of `eai analyze table`.

    Attributes:
        formats: csv or parquet, or both with a comma. parquet needs the extra 'analysis'.
    """

    formats: Annotated[tuple[Literal["csv", "parquet"], ...], BeforeValidator(split_option_at_commas)] = (
        "csv",
    )


def analyze(
    name: Annotated[str, typer.Argument(metavar="STUDY")] = "",
    records: Annotated[list[Path] | None, typer.Argument(help=options.RECORDS)] = None,
    out: Annotated[Path | None, make_flag(panel=OUTPUT)] = None,
    settings: Annotated[list[str] | None, make_flag(options.SETTING, metavar="OPTION=VALUE")] = None,
    plots: Annotated[bool, make_flag(panel=OUTPUT)] = True,
    formats: Annotated[str, make_flag(panel=OUTPUT, metavar="svg,png,pdf")] = FORMATS[0],
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Make the tables and plots of a study of records; without a name, list the studies and their options.

    all: every study that needs no special records; records are read once. table: records as tidy tables,
    with one row for each answer (with features of its task), step, goal, atom or clause.

    Example: eai analyze errors scores --out errors

    Options:
        name: Name of a study, all, or table.
        out: Folder for the results; default: the study's name.
        settings: An option of the study.
        plots: Draw plots (needs the extra 'plots').
        formats: File formats of plots.
    """
    if not name:
        print_markdown("\n".join(_list_studies_as_markdown()))
        return
    _refuse_unknown_study(name)
    if not records:
        raise InputError(f"{name}: expected records: files, or folders with records.jsonl below")
    folder, kinds = out or Path(name), parse_formats(formats) if plots else []
    with options.open_data_source(data) as source, require_extra("analysis", "this analysis needs"):
        read = StudyRecords(
            tuple(records), folder, source, print_note, partial(show_scoring_progress, quiet=False)
        )
        if name == TABLE:
            _write_tidy_tables(
                read,
                options.apply_settings_to_section(TABLE, _TableFileOptions, settings or ()),
                as_json=as_json,
            )
            return
        written = list(_write_analyses_of_studies(name, read, settings or (), formats=kinds, as_json=as_json))
    if as_json:
        print_result(value=written, as_json=True)


def _list_studies_as_markdown() -> Iterator[str]:
    """Yield the lines of a Markdown table of studies (analyses of records) and their options."""
    yield "| study, option | if not given | meaning |"
    yield "|---|---|---|"
    for name in list_study_names():
        study = find_study(name)
        if study.analyze is not None:
            yield f"| **{name}** | | {study.title} |"
            yield from options.format_option_rows(study.choices)
    yield f"| **{ALL}** | | {', '.join(each.name for each in _find_study_or_all(ALL))}, a folder each. |"
    yield f"| **{TABLE}** | | Records as tidy tables. |"
    yield from options.format_option_rows(_TableFileOptions)


def _refuse_unknown_study(name: str) -> None:
    known = (*list_study_names(), ALL, TABLE)
    if name not in known:
        raise InputError(f"{name!r} is no study: there are {', '.join(known)}{did_you_mean(name, known)}")


def _find_study_or_all(study_name_or_all: str) -> list[Study]:
    """Return the study (tables and plots on one question) with a name, or all studies for the name `all`."""
    if study_name_or_all == ALL:
        return [each for each in map(find_study, list_study_names()) if each.included_in_all]
    return [] if study_name_or_all == TABLE else [find_study(study_name_or_all)]


def _write_analyses_of_studies(
    study_or_all: str,
    records: StudyRecords,
    settings: Sequence[str],
    *,
    formats: Sequence[str],
    as_json: bool,
) -> Iterator[Json]:
    """Write the tables and plots of one study, or of all studies; yield the JSON value of each analysis.

    Among several studies, a study without enough records is left out with a note to the user.
    """
    studies = _find_study_or_all(study_or_all)
    if study_or_all != ALL:
        yield from write_analyses_of_study(studies[0], records, settings, formats=formats, as_json=as_json)
        return
    settings_of_studies = {study.name: _select_settings_of_study(study, settings) for study in studies}
    for text in settings:
        if not any(text in own for own in settings_of_studies.values()):
            known = [option for study in studies for option in study.choices.model_fields]
            hint = did_you_mean(text.partition("=")[0], known)
            raise InputError(f"{options.SETTING} {text}: no study of {ALL} has this option{hint}")
    records.make_tidy_tables_of_comparable_runs()
    for study in studies:
        own, place = settings_of_studies[study.name], records.change_to_subfolder(study.name)
        try:
            yield from write_analyses_of_study(study, place, own, formats=formats, as_json=as_json)
        except InputError as error:
            records.note(f"{study.name}: {error}")


def _select_settings_of_study(study: Study, settings: Sequence[str]) -> list[str]:
    names = [options.split_name_and_value(text)[0].removeprefix(f"{study.name}.") for text in settings]
    return [text for text, name in zip(settings, names, strict=True) if name in study.choices.model_fields]


def write_analyses_of_study(
    study: Study,
    records: StudyRecords,
    settings: Sequence[str],
    *,
    formats: Sequence[str] = FORMATS[:1],
    as_json: bool,
    writes: bool = True,
) -> Iterator[Json]:
    """Write a study's tables, and its figures in some formats; yield the JSON value of each analysis.

    If no files are to be written, only print the tables.

    Raises:
        InputError: the study has no analysis, or the folder cannot be written.
    """
    if study.analyze is None:
        raise InputError(
            f"{study.name}: this study has no analysis; `eai score` and `eai report` show its runs"
        )
    for analysis in study.analyze(
        records, options.apply_settings_to_section(study.name, study.choices, settings)
    ):
        folder, drawn = records.folder / analysis.folder if writes else None, 0
        if folder is not None:
            write_tables(folder, study.name, analysis.tables, analysis.remarks)
            write_files(folder, analysis.pages)
            drawn = _write_and_count_figures(analysis.figures, folder, formats) if formats else 0
        if not as_json:
            _print_analysis(analysis, drawn, folder)
        names = [table.name for table in analysis.tables]
        place = None if folder is None else str(folder)
        yield {"folder": place, "tables": names, "plots": drawn, **analysis.facts}


def _write_and_count_figures(figures: Figures, folder: Path, formats: Sequence[str]) -> int:
    """Write figures in some formats, and return their number.

    Without matplotlib, print a remark and return 0.

    Raises:
        InputError: the folder cannot be written.
    """
    drawn = 0
    with raise_write_errors_as_input_errors(folder):
        try:
            with use_plot_style():
                for name, figure in figures:
                    if figure is not None:
                        write_figure(figure, folder / name, formats)
                        drawn += 1
        except EaiError as error:
            get_error_console().print(f"no plots: {error}", markup=False, highlight=False, soft_wrap=True)
    return drawn


def _print_analysis(analysis: Analysis, plot_count: int, folder: Path | None) -> None:
    """Print the tables that are meant for the screen, all remarks, and the folder of written files.

    If no table is meant for the screen, print only how many tables and plots were written, and the folder.
    """
    if not analysis.screen_tables:
        print_result_line(
            f"{format_count(len(analysis.tables), 'table')}, {format_count(plot_count, 'plot')}; in {folder}"
        )
        return
    for table in analysis.screen_tables:
        print_table(get_output_console(), _drop_constant_columns(table))
    for line in analysis.remarks:
        get_output_console().print(line, markup=False, highlight=False)
    if folder is not None:
        pages = "".join([f"; open {folder / name}" for name in analysis.pages])
        line = f"written to {folder}{pages}"
        get_output_console().print(line, soft_wrap=True, highlight=False, markup=False)


def _drop_constant_columns(table: Table) -> Table:
    """Return a table without suite columns (protocol, domain, ability) that have one value in all rows.

    These values are added to the title of the table.
    """
    rows = table.row_dicts()
    common = [
        name for name in SUITE if name in table.column_names and len({str(row[name]) for row in rows}) == 1
    ]
    title = f"{table.title} ({', '.join([str(rows[0][name]) for name in common])})" if common else table.title
    return replace(table.drop_columns(common), title=title)


def _write_tidy_tables(records: StudyRecords, chosen: _TableFileOptions, *, as_json: bool) -> None:
    made = records.make_all_tables()
    out, tables = records.folder, {name: getattr(made, name) for name in TABLES}
    for written in dict.fromkeys(chosen.formats):
        for name, lines in tables.items():
            if written == "parquet":
                write_parquet(out / f"{name}.parquet", TABLES[name], lines)
            else:
                write_files(out, {f"{name}.csv": format_lines_as_csv(TABLES[name], lines)})
    sizes: dict[str, Json] = {name: len(lines) for name, lines in tables.items()}
    line = ", ".join(format_count(len(lines), name.removesuffix("s")) for name, lines in tables.items())
    print_result(f"{line}; in {out}", value={"folder": str(out), "lines": sizes}, as_json=as_json)
