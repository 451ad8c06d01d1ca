"""Build a board: a page of results that are computed from submitted answers.

A submission is a folder or a zip with response files, a ``submission.toml`` and, if `eai run` wrote it, a
``run.toml``. Its content is not trusted: sizes are limited, links and unknown tasks are refused, names are
escaped, and every number is computed by scoring the answers. A season is a folder of generated tasks. Its
manifest (seed and digests of the tasks) is published before the tasks. The secret number from which the tasks
are generated is published after the season.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import date
from functools import cache
from html import escape
from itertools import compress
from pathlib import Path

from pydantic import Field

from eai import __version__
from eai.abilities.declaration import MetricColumn, get_declaration
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.files import MAX_UNPACKED, find_files_below, parse_toml, read_toml
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.sets import (
    MANIFEST,
    find_reasons_to_doubt_published_set,
    find_task_file_of_split,
    read_manifest_entry_of_secret_set,
)
from eai.benchmarks.registry import find_benchmark, get_title
from eai.benchmarks.suite import Suite, open_suite
from eai.results.answer_files import ZIP, find_suite_files, unpack_answers_if_zipped
from eai.results.batch import map_unanswered_tasks_to_reason, score_run
from eai.results.options import ScoringOptions
from eai.results.page import build_page
from eai.results.paper_tables import is_trivial_baseline
from eai.results.responses import ENDINGS, PARQUET, ResponseFile, read_responses
from eai.results.runs import Run, RunKey
from eai.studies.report.rankings import RankedModel, RankedScore, Ranking, make_rankings
from eai.studies.report.run_summary import RunSummary, summarize_run
from eai.tasks.options import Options
from eai.tasks.source import Source

DESCRIPTION, SPECIFICATION, SEASON = "submission.toml", "run.toml", "season.toml"
"""Names of the files that describe a submission, the run behind a submission, and a season.

A season is a set of new tasks that stays secret until the season opens.
"""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_MAX_FILES, _MAX_CHARACTERS, _MAX_DESCRIPTION_BYTES = 200, 100_000, 64_000
"""Maximum numbers of files in a submission, of characters in an answer, and of bytes in a description."""

_MAX_TOKENS, _MAX_DOLLARS = 10**15, 10**9
"""Largest numbers of tokens and of dollars that a submission may state."""

_NO_NUMBER = "–"


class _SubmissionDescription(Options):
    """The content of ``submission.toml``. Costs are for all answers together, in US dollars."""

    model: str = Field(min_length=1, max_length=100)
    date: date
    by: str = Field("", max_length=100)
    harness: str = Field("", max_length=100)
    effort: str = Field("", max_length=100)
    logs: str = Field("", max_length=500, pattern=r"^(https://[^\s]+)?$")
    tokens: int | None = Field(None, ge=0, le=_MAX_TOKENS)
    dollars: float | None = Field(None, ge=0, le=_MAX_DOLLARS)
    withdrawn: str = Field("", max_length=500)


class _LeaderboardSeasonFile(Options):
    """The content of ``season.toml``, which describes a season (a set of new tasks that were secret before).

    It has a title and the name of the task file. After the season, it also has the secret number from which
    anybody can generate the tasks again.
    """

    title: str = Field(min_length=1, max_length=100)
    split: str = "test"
    secret: str = ""


@dataclass(frozen=True, slots=True)
class _ScoredSubmission:
    name: str
    description: _SubmissionDescription
    specification: str
    summaries: tuple[RunSummary, ...]


def build_page_and_count_submissions(
    paths: Sequence[Path], data_source: Source, *, report_submission: Callable[[str], None]
) -> tuple[str, int]:
    """Return a web page that ranks submissions and lists seasons, and the number of submissions.

    A season is a set of generated tasks that submissions can answer too.

    Args:
        paths: folders or zips of single submissions, folders of single seasons, or folders of these.
        data_source: the data set, and the planner that judges operators.
        report_submission: called with the name of each submission before the submission is scored.

    Raises:
        InputError: a submission or a season is invalid. The message names it and the reason.
        DataError: the data set cannot be obtained.
    """
    places = [each for path in paths for each in _list_submissions_and_leaderboard_seasons(path)]
    seasons = [_read_leaderboard_season(place) for place in places if (place / MANIFEST).is_file()]
    opened: dict[str, Benchmark] = {}
    for benchmark, _ in seasons:
        if benchmark is not None and opened.setdefault(benchmark.name, benchmark) is not benchmark:
            raise InputError(f"another season has tasks of the name {benchmark.name}; use another --split")

    @cache
    def open_suite_of_domain(domain: str, ability: Ability) -> Suite:
        return open_suite(opened.get(domain, domain), ability, source=data_source)

    submissions: dict[str, _ScoredSubmission] = {}
    for place in places:
        if (place / MANIFEST).is_file():
            continue
        name = _read_submission_name(place)
        if name in submissions:
            raise InputError(f"{place}: another submission has the name {name}; rename one")
        report_submission(name)
        with _unpack_and_check_submission(place) as folder:
            submissions[name] = _score_submission(name, folder, opened, open_suite_of_domain)
    return _build_page_html(submissions, [html for _, html in seasons]), len(submissions)


def _list_submissions_and_leaderboard_seasons(path: Path) -> list[Path]:
    """Return the paths of submissions and seasons (sets of generated tasks) in a folder, sorted by name.

    If the path is itself a submission or a season, it is the only result.
    """
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    if path.suffix.lower() == ZIP or any((path / name).is_file() for name in (DESCRIPTION, MANIFEST)):
        return [path]
    if not path.is_dir():
        raise InputError(f"{path}: expected the folder or the zip of a submission, or a folder of these")
    entries = [each for each in sorted(path.iterdir()) if not each.name.startswith(".")]
    return [each for each in entries if each.is_dir() or each.suffix.lower() == ZIP]


def _read_submission_name(place: Path) -> str:
    name = place.name.removesuffix(place.suffix) if place.suffix.lower() == ZIP else place.name
    if not _NAME.fullmatch(name) or is_trivial_baseline(name):
        raise InputError(f"{place}: expected a name of letters, digits, '.', '_' and '-', 64 at most")
    return name


@contextmanager
def _unpack_and_check_submission(place: Path) -> Iterator[Path]:
    """Unpack a submission and yield its folder. Raise InputError if it has links or is too large."""
    if place.is_symlink():
        raise InputError(f"{place}: is a link; a submission must be a folder or a zip")
    with unpack_answers_if_zipped(place, (DESCRIPTION, SPECIFICATION)) as folder:
        described = find_files_below(folder, DESCRIPTION)
        if len(described) != 1:
            raise InputError(f"{place}: expected one {DESCRIPTION} in it, found {len(described)}")
        files = list(folder.rglob("*"))
        for file in files:
            if file.is_symlink():
                raise InputError(f"{file}: is a link; a submission may only have files and folders")
        if len(files) > _MAX_FILES or sum(file.lstat().st_size for file in files) > MAX_UNPACKED:
            raise InputError(
                f"{place}: a submission may have at most {_MAX_FILES} files and {MAX_UNPACKED:,} bytes"
            )
        yield described[0].parent


def _score_submission(
    name: str, folder: Path, seasons: Collection[str], suite_of: Callable[[str, Ability], Suite]
) -> _ScoredSubmission:
    """Score the submission in a folder. A withdrawn submission is described, but not scored."""
    description = _SubmissionDescription.read_file(_require_small_file(folder / DESCRIPTION))
    specification, text = _require_small_file(folder / SPECIFICATION), ""
    if specification.is_file():
        read_toml(specification)
        text = specification.read_text(encoding="utf-8")
    if description.withdrawn:
        return _ScoredSubmission(name, description, text, ())
    summaries = [
        _summarize_answers(name, file.path, file.domain, suite_of(file.domain, file.ability))
        for file in find_suite_files(folder, seasons)
    ]
    asked = [(each.key.domain, each.key.ability) for each in summaries]
    for domain, ability in asked:
        if (count := asked.count((domain, ability))) > 1:
            raise InputError(
                f"{folder}: expected one file with answers to {domain} {ability.value}, found {count}"
            )
    return _ScoredSubmission(
        name, description, text, tuple(sorted(summaries, key=lambda each: each.key.sort_key))
    )


def _summarize_answers(name: str, file: Path, domain: str, suite: Suite) -> RunSummary:
    answers = replace(_read_answers(file, suite), model=name)
    records = score_run(
        suite, answers, map_unanswered_tasks_to_reason(suite, answers), ScoringOptions(explanations=False)
    )
    return summarize_run(Run(RunKey(suite.protocol, domain, suite.ability, name), tuple(records)))


def _read_answers(file: Path, suite: Suite) -> ResponseFile:
    """Return the answers of a response file; raise InputError for unknown tasks and too long answers."""
    if file.name.endswith(PARQUET):
        raise InputError(f"{file}: expected one of {', '.join(set(ENDINGS) - {PARQUET})}")
    answers = read_responses(file, suite.task_ids, suite.benchmark.data.task_id_of)
    if answers.skipped_rows:
        raise InputError(
            f"{file}: {answers.skipped_rows} answers are to tasks that are not in the data set; "
            "remove these answers or correct their task ids"
        )
    made_by = get_declaration(suite.ability).read_episode_settings
    for response in answers.responses:
        made = made_by(response.text)
        if made is not None and made.rules is not None:
            raise InputError(
                f"{file}: expected episodes under the default game rules, as only these are ranked; "
                f"found other game rules in the answer to {response.task_id}: {made.rules}"
            )
        if len(response.text) > _MAX_CHARACTERS:
            raise InputError(
                f"{file}: the answer to {response.task_id}: expected at most {_MAX_CHARACTERS:,} characters, "
                f"found {len(response.text):,}"
            )
    return answers


def _read_leaderboard_season(folder: Path) -> tuple[Benchmark | None, str]:
    """Return the tasks of a season (None before they are published), and HTML that describes the season.

    Raises:
        InputError: the tasks differ from the announced tasks, or do not follow from the season's secret.
    """
    chosen = _LeaderboardSeasonFile.read_file(_require_small_file(folder / SEASON))
    entry = read_manifest_entry_of_secret_set(folder, chosen.split)
    file = find_task_file_of_split(folder, chosen.split)
    state, benchmark = "announced; its tasks are not published yet", None
    if file is not None:
        for problem in find_reasons_to_doubt_published_set(folder, chosen.split, chosen.secret or None):
            raise InputError(
                f"{folder}: expected the task file and the secret that {MANIFEST} announces, but {problem}; "
                "restore the announced ones"
            )
        state, benchmark = "open: its tasks are those announced", find_benchmark(str(file))
        if chosen.secret:
            state = f"over: its secret is revealed, and {entry['tasks']} tasks follow from it"
    facts = {
        "seed": entry["seed"],
        "SHA-256 of the secret": entry["secret_sha256"],
        "SHA-256 of the tasks": entry["sha256"],
    }
    listed = "".join(
        f"<dt>{name}</dt><dd><code>{escape(str(value))}</code></dd>" for name, value in facts.items()
    )
    told = f"<h2>{escape(chosen.title)}</h2><p>The season is {escape(state)}.</p>"
    return benchmark, f"<section>{told}<dl>{listed}</dl></section>"


def _require_small_file(file: Path) -> Path:
    """Return the given path; raise InputError if the file is too large.

    The file describes a submission, its run, or a season (a folder of generated tasks).
    """
    if file.is_file() and file.stat().st_size > _MAX_DESCRIPTION_BYTES:
        raise InputError(f"{file}: expected at most {_MAX_DESCRIPTION_BYTES:,} bytes")
    return file


def _build_page_html(submissions: Mapping[str, _ScoredSubmission], season_sections: Sequence[str]) -> str:
    summaries = [summary for submission in submissions.values() for summary in submission.summaries]
    summaries.sort(key=lambda summary: summary.key.sort_key)
    tables = make_rankings(summaries, with_paper=True)
    parts = list(season_sections)
    for domain, of_domain in group_pairs((table.domain, table) for table in tables).items():
        parts.append(f"<section><h2>{escape(get_title(domain))}</h2>")
        for number, table in enumerate(of_domain):
            opened = " open" if number == 0 else ""
            summary = f"<summary>{escape(table.title)}</summary>"
            parts.append(f"<details{opened}>{summary}{_format_ranking_html(table, submissions)}</details>")
        parts.append("</section>")
    if not tables:
        parts.append("<p>There is no submission yet.</p>")
    parts.append("<section><h2>Submissions</h2></section>")
    parts += _format_submission_sections(submissions.values())
    version = f"Scored by eai {__version__}."
    return build_page("eai.extensions.board", "board", (), "\n".join([*parts, f"<footer>{version}</footer>"]))


_HEADINGS_BEFORE_METRICS = ("#", "Model")
"""Headings of the columns of a table before the columns of metrics."""
_HEADINGS_AFTER_METRICS = (
    *("Answered", "Prompts", "Harness", "Effort", "Date", "Tokens", "Dollars", "Protocol", "Errata", "Logs"),
)
"""Headings of the columns of a table after the columns of metrics."""


def _format_ranking_html(table: Ranking, submissions: Mapping[str, _ScoredSubmission]) -> str:
    columns = sorted(table.columns, key=lambda column: column != table.primary)
    headings = [f"{column.group}: {column.label}" if column.group else column.label for column in columns]
    rows = [_list_row_cells(row, columns, table, submissions) for row in table.rows]
    used = [any(cell not in ("", _NO_NUMBER) for cell in column) for column in zip(*rows, strict=True)]
    names = map(escape, (*_HEADINGS_BEFORE_METRICS, *headings, *_HEADINGS_AFTER_METRICS))
    head = "".join(f"<th>{name}</th>" for name in compress(names, used))
    body = "".join(
        _format_cells_html(compress(cells, used), "" if row.source == "run" else ' class="other"')
        for row, cells in zip(table.rows, rows, strict=True)
    )
    notes = "".join(f"<li>{escape(note)}</li>" for note in table.notes)
    shown = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return (
        f"<p>{escape(table.make_table().definition)}. In brackets: 95 % intervals.</p>"
        f'<div class="wide" tabindex="0">{shown}</div><ol>{notes}</ol>'
    )


def _list_row_cells(
    row: RankedModel,
    columns: Sequence[MetricColumn],
    table: Ranking,
    submissions: Mapping[str, _ScoredSubmission],
) -> list[str]:
    """Return the HTML of a row's cells, with an empty text or a dash for an unknown value."""
    submission = submissions[row.model] if row.source == "run" else None
    rank = _NO_NUMBER if row.rank is None else str(row.rank)
    numbers = [_format_score_html(row.scores[column], table) for column in columns]
    answered = _NO_NUMBER if row.coverage is None else str(row.coverage)
    protocol, marks = table.protocol.value, _format_note_marks(table.find_footnote_numbers(row.notes))
    if submission is None:
        model = f"{escape(row.model)}{marks} <small>{escape(row.source)}</small>"
        return [rank, model, *numbers, answered, *[""] * 6, protocol, "", ""]
    model = f'<a href="#{escape(submission.name)}">{escape(submission.description.model)}</a>{marks}'
    submission_cells = [
        escape(_extract_prompt_set_label(submission.specification)),
        *_format_description_cells(submission.description),
        protocol,
        _describe_errata_of_benchmark_tasks(submission, table),
        _format_logs_link(submission),
    ]
    return [rank, model, *numbers, answered, *submission_cells]


def _format_cells_html(cells: Iterable[str], attributes: str = "") -> str:
    return f"<tr{attributes}>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _format_score_html(value: RankedScore, table: Ranking) -> str:
    if value.value is None:
        return _NO_NUMBER
    shown = f"<b>{value.value:.1f}</b>" if value.best else f"{value.value:.1f}"
    if value.low is not None and value.high is not None:
        shown += f" <small>[{value.low:.1f}, {value.high:.1f}]</small>"
    return shown + _format_note_marks(table.find_footnote_numbers(value.texts))


def _format_note_marks(notes: Iterable[int]) -> str:
    listed = ", ".join(map(str, notes))
    return f"<sup>{listed}</sup>" if listed else ""


def _format_description_cells(description: _SubmissionDescription) -> Sequence[str]:
    """Return cells with harness (agent program), effort, date, tokens and dollars, as the submission says."""
    tokens = "" if description.tokens is None else f"{description.tokens:,}"
    dollars = "" if description.dollars is None else f"{description.dollars:,.2f}"
    return [escape(description.harness), escape(description.effort), str(description.date), tokens, dollars]


def _extract_prompt_set_label(run_specification: str) -> str:
    """Return the prompt set of a run specification, followed by ``, NAME`` if the user's prompts have a name.

    An empty specification gives an empty text.
    """
    if not run_specification:
        return ""
    chosen = parse_toml(run_specification).get("prompts")
    named = chosen if isinstance(chosen, dict) else {}
    return ", ".join([str(named.get("set", "official")), *([str(named["name"])] if "name" in named else [])])


def _describe_errata_of_benchmark_tasks(submission: _ScoredSubmission, table: Ranking) -> str:
    """Return a cell on corrections of the data set (errata) under which answers were scored.

    It names the version of the errata, and how many tasks of a table they leave out and correct.
    """
    abilities = {column.ability for column in table.columns}
    errata = [
        summary.errata
        for summary in submission.summaries
        if summary.key.domain == table.domain and summary.key.ability in abilities and summary.errata
    ]
    if not errata:
        return "none"
    left_out, corrected = (
        sum(len(getattr(each, name)) for each in errata) for name in ("left_out", "corrected")
    )
    return f"{escape(errata[0].version)}: {left_out} left out, {corrected} corrected"


def _format_logs_link(submission: _ScoredSubmission) -> str:
    logs = submission.description.logs
    return f'<a href="{escape(logs)}" rel="nofollow noreferrer">logs</a>' if logs else ""


def _format_submission_sections(submissions: Iterable[_ScoredSubmission]) -> Iterator[str]:
    """Yield a section for each submission: its author, its run specification, and why it was withdrawn."""
    for submission in submissions:
        by = f", by {escape(submission.description.by)}" if submission.description.by else ""
        yield f'<section id="{escape(submission.name)}"><h3>{escape(submission.description.model)}</h3>'
        yield f"<p>{escape(submission.name)}, {submission.description.date}{by}.</p>"
        if submission.description.withdrawn:
            yield f"<p><b>Withdrawn:</b> {escape(submission.description.withdrawn)}</p>"
        if submission.specification:
            text = f"<pre>{escape(submission.specification)}</pre>"
            yield f"<details><summary>Run specification</summary>{text}</details>"
        yield "</section>"
