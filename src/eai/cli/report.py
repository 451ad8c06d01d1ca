"""``eai report``: write tables, plots and the page ``explorer.html`` from records (scored answers)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import MetricColumn, get_declaration
from eai.abilities.protocol import PAPER_ABILITIES
from eai.base.entry_points import load_from_extension
from eai.base.errors import EaiError, InputError
from eai.base.files import raise_write_errors_as_input_errors, write_files_atomically
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.packs import is_stored
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, get_title, list_benchmarks
from eai.cli.console import format_count, get_output_console, print_note, print_result, print_result_line
from eai.cli.options import RECORDS, AsJson, DataFolder, Wide, make_flag, open_store, split_names
from eai.cli.progress import show_scoring_progress
from eai.results.answer_files import find_benchmarks_of_runs
from eai.results.cost import PriceList
from eai.results.plots import FORMATS, parse_formats
from eai.results.record import Record
from eai.results.runs import find_record_files, read_runs, recount_goals_as_in_paper
from eai.results.table import Table, format_superscript
from eai.results.terminal import print_table
from eai.studies.report.document import make_remark_on_missing_task_names
from eai.studies.report.explorer import (
    DomainDataOfExplorerPage,
    ExplorerPageData,
    build_explorer_page,
    make_film_file_name,
)
from eai.studies.report.plots import add_plots_to_report
from eai.studies.report.rankings import Ranking, make_rankings
from eai.studies.report.run_summary import (
    RunSummary,
    select_runs_with_standard_rules_and_no_study,
    summarize_run,
)
from eai.studies.report.writer import format_rankings_json, format_tables_latex, write_report_and_count_tables
from eai.tasks.source import Source

_FILMS = "films"
EXPLORER = "explorer.html"
_OVERVIEW = "overview"
_LATEX = "For a paper"


def report(
    records: Annotated[list[Path], typer.Argument(help=RECORDS)],
    out: Path | None = None,
    paper: bool = False,
    plots: bool = True,
    summary: bool = False,
    prompts: bool = True,
    pictures: bool = False,
    models: Annotated[str | None, make_flag(panel=_LATEX, metavar="NAME,...")] = None,
    columns: Annotated[str | None, make_flag(panel=_LATEX, metavar="HEADING,...")] = None,
    intervals: Annotated[bool, make_flag(panel=_LATEX)] = True,
    formats: Annotated[str, make_flag(panel=_LATEX, metavar="svg,png,pdf")] = FORMATS[0],
    prices: Path | None = None,
    as_json: AsJson = False,
    wide: Wide = False,
    data: DataFolder = None,
) -> None:
    """Print the main results of runs; with --out, write tables, plots and the HTML explorer.

    The command prints one table for each domain and protocol, best model first. Abilities beyond the paper
    have tables of their own. Tables are written as Markdown, LaTeX, CSV and JSON.

    Example: eai report scores --paper

    Example: eai report scores --out report --paper

    Options:
        out: Folder of the report; without it the main results are printed.
        paper: Show the paper's models beside the runs.
        plots: Draw plots (needs the extra 'plots').
        summary: Also draw one page for each model.
        prompts: Put prompts and the data set's operators into the explorer.
        pictures: Put a picture of each step's state into the explorer.
        models: Only these models in LaTeX tables.
        columns: Only these columns in LaTeX tables.
        intervals: 95 % intervals below the numbers in LaTeX tables.
        formats: File formats of plots.
        prices: Token prices for answers without a cost: TOML with date, source and models.
    """
    if out is None:
        _print_main_results(records, paper=paper, as_json=as_json, wide=wide)
        return
    kinds = parse_formats(formats)
    listed_prices = None if prices is None else PriceList.read_file(prices)
    own = find_benchmarks_of_runs(records)
    told = partial(
        read_domain_data_for_explorer_page, open_store(data), own, out, prompts=prompts, pictures=pictures
    )
    explorer, summaries = ExplorerPageData(told), list[RunSummary]()
    files = len(find_record_files(records))
    with show_scoring_progress("reading records", files, quiet=False) as watch:
        for number, run in enumerate(read_runs(records), 1):
            summaries.append(summarize_run(recount_goals_as_in_paper(run) if paper else run))
            explorer.add_run(run)
            watch(min(number, files))
    summaries.sort(key=lambda item: item.key.sort_key)
    plain = select_runs_with_standard_rules_and_no_study(summaries)
    tables = make_rankings(plain, with_paper=paper)
    with raise_write_errors_as_input_errors(out):
        out.mkdir(parents=True, exist_ok=True)
        tex = partial(
            format_tables_latex, models=split_names(models), columns=split_names(columns), intervals=intervals
        )
        written = write_report_and_count_tables(
            out, summaries, tables, tex, with_paper=paper, prices=listed_prices
        )
        write_files_atomically({out / EXPLORER: build_explorer_page(explorer.format_data_as_base64_lines())})
        drawn = _draw_and_count_plots(out, plain, tables if summary else (), kinds) if plots else 0
    shown = out / EXPLORER
    numbers = {"run": len(summaries), "table": written, "plot": drawn}
    line = f"{', '.join(format_count(number, noun) for noun, number in numbers.items())}; open {shown}"
    made = {f"{noun}s": number for noun, number in numbers.items()}
    print_result(line, value={**made, "folder": str(out), "explorer": str(shown)}, as_json=as_json)


def _draw_and_count_plots(
    out: Path, runs: Sequence[RunSummary], summary_rankings: Sequence[Ranking], formats: Sequence[str]
) -> int:
    """Draw the plots of a report and return their number, or print a remark if matplotlib is missing.

    Raises:
        InputError: a file cannot be written.
    """
    try:
        return add_plots_to_report(
            out, runs, summary_rankings, formats, partial(show_scoring_progress, quiet=False)
        )
    except InputError:
        raise
    except EaiError as error:
        print_note(f"no plots: {error}")
        return 0


def read_domain_data_for_explorer_page(
    source: DataPackStore,
    own_benchmarks: Mapping[str, Benchmark],
    out: Path,
    domain: str,
    *,
    prompts: bool,
    pictures: bool,
) -> DomainDataOfExplorerPage:
    """Return information about a domain's tasks, from the installed data set or the user's own benchmark.

    Nothing is downloaded.

    Args:
        source: Location of the data set, if it is installed.
        own_benchmarks: The user's own benchmarks by name.
        out: Folder of the report, which may contain films.
        domain: Name of the domain.
        prompts: Whether prompts are wanted.
        pictures: Whether pictures of scenes are wanted.

    Raises:
        InputError: Pictures are wanted, and the data set is not installed.
    """
    if pictures and not is_stored(source, domain):
        raise InputError("--pictures: the data set is not on this machine; eai data fetch downloads it")
    known = domain in own_benchmarks or (domain in list_benchmarks() and is_stored(source, domain))
    words = (
        _collect_texts_for_explorer_page(own_benchmarks.get(domain) or find_benchmark(domain), source)
        if prompts and known
        else DomainDataOfExplorerPage()
    )
    if (out / _FILMS).is_dir():
        words = replace(words, find_film=partial(_find_animation_path, out))
    if pictures:
        return replace(
            words, find_scenes=load_from_extension("diagrams_of_answers", "--pictures")(Source(source))
        )
    return words


def _find_animation_path(out: Path, record: Record) -> str:
    """Return the path, in the report, of an answer's animation (`eai explain --film`); empty if none."""
    address = f"{_FILMS}/{make_film_file_name(record)}"
    return address if (out / address).is_file() else ""


def _collect_texts_for_explorer_page(benchmark: Benchmark, store: DataPackStore) -> DomainDataOfExplorerPage:
    """Return the prompts and operators of a benchmark for the page ``explorer.html``.

    Texts that are not available are left out.
    """
    source, prompts, operators = Source(store), dict[str, dict[str, str]](), dict[str, str]()
    for ability in PAPER_ABILITIES:
        with suppress(EaiError):
            prompts_of_ability = PromptLibrary("official", None, source).open(benchmark, ability)
            prompts[ability.value] = {
                task_id: "\n\n".join(filter(None, (prompt.system, prompt.user)))
                for task_id, prompt in prompts_of_ability.items()
            }
    with suppress(EaiError):
        tasks = benchmark.operator_tasks(source).values()
        operators = {name: text.write_pddl for task in tasks for name, text in task.domain.operators.items()}
    instructions = {task.id: task.instruction for task in benchmark.tasks(source).values()}
    return DomainDataOfExplorerPage(prompts, operators, instructions)


def _print_main_results(records: Sequence[Path], *, paper: bool, as_json: bool, wide: bool) -> None:
    """Print a table of main results for each domain and protocol (scoring rules)."""
    summaries = [
        summarize_run(recount_goals_as_in_paper(run) if paper else run) for run in read_runs(records)
    ]
    summaries.sort(key=lambda item: item.key.sort_key)
    ranked = select_runs_with_standard_rules_and_no_study(summaries)
    shown = {_OVERVIEW, *{item.key.ability.value for item in ranked}.difference(PAPER_ABILITIES)}
    tables = [table for table in make_rankings(ranked, with_paper=paper) if table.name in shown]
    if as_json:
        print(format_rankings_json(tables), end="")
        return
    for table in tables:
        print_table(get_output_console(), _format_overview(table), wide=wide)
        for number in table.find_footnote_numbers(chain.from_iterable(row.notes for row in table.rows)):
            print_result_line(f"{format_superscript((number,))} {table.notes[number - 1]}")
    if len(ranked) < len(summaries):
        left_out = format_count(len(summaries) - len(ranked), "experiment")
        print_note(f"left out: {left_out}, which eai report shows apart")
    remark = make_remark_on_missing_task_names(ranked)
    if remark:
        print_note(remark)


def _format_overview(ranking: Ranking) -> Table:
    """Return the table of main results for the screen: protocol in the title, abilities above columns."""
    table = ranking.make_table()
    first = len(table.columns) - len(ranking.columns)
    headings = map(_format_column_heading, ranking.columns)
    columns = [
        replace(column, heading_without_group=text)
        for column, text in zip(table.columns_with_headings[first:], headings, strict=True)
    ]
    unit = f"percent{ranking.rank_column_caption}"
    title = f"{get_title(ranking.domain)}, protocol {ranking.protocol.value} ({unit})"
    return replace(table, title=title, columns=(*table.columns[:first], *columns))


def _format_column_heading(column: MetricColumn) -> str:
    label = column.label.lower() if column.label != "F1" else column.label
    return label if column.ability is None else f"{get_declaration(column.ability).short_title}\n{label}"
