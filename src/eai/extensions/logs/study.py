"""`eai analyze logs`: outcomes, first errors and goal progress of episodes in other projects' logs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from eai.base.grouping import group_pairs
from eai.benchmarks.registry import find_benchmark
from eai.extensions.logs.episode import CANNOT_TELL, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.explorer import make_explorer_page
from eai.extensions.logs.readers import read_logs
from eai.extensions.logs.twin import make_table_of_benchmark_tasks_named_in_logs
from eai.results.plots import COLUMN, RULE, make_figure, wrap_label
from eai.results.rate import Rate
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Study
from eai.tasks.options import Options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMES = ("log", "agent", "setting")
"""Columns that identify a group of episodes: the form of the log, the agent, and the setting."""

_EPISODE_COLUMNS = (
    *("task", "outcome", "ending", "kind", "unseen", "actions", "first_error", "best", "best_action", "end"),
    *("repeats", "seconds", "calls", "tokens", "words"),
)
"""Columns of the table of episodes, after the columns for the form of the log, agent and setting."""

_FILE_ONLY = ("ending", "unseen", "best_action", "end", "repeats", "seconds", "calls", "tokens", "words")
"""Columns of the tables of outcomes and episodes that files contain but the screen does not show."""

_TERMINAL_COLUMNS_OF_SAME_NAMED_TASKS = ("task", "outcomes", "hidden", "plan")
"""Columns of the table `twins` in the terminal: benchmark tasks that have the names of logged tasks."""

_MAX_WORDS_CHARACTERS = 200
"""Maximum number of characters of an agent's words in a table."""

_Groups: TypeAlias = Mapping[tuple[str, str, str], Sequence[LoggedEpisode]]

_COLORS = dict(
    zip(EpisodeOutcome, ["#3f7f62", "#d8b455", "#e0905a", "#b8a98c", "#5d5f72", "#e6e3db"], strict=True)
)


class _EpisodeLogOptions(Options):
    """Options of `eai analyze logs`.

    Attributes:
        tasks: A benchmark with the tasks of the logs, such as alfworld:FOLDER. Logged actions are replayed in
            these tasks. For each task name in the logs, the table twins describes the benchmark's task.
    """

    tasks: str = ""


def _analyze_logs(records: StudyRecords, options: _EpisodeLogOptions) -> Iterator[Analysis]:
    benchmark = find_benchmark(options.tasks) if options.tasks else None
    logs = read_logs(records.paths, benchmark, records.source)
    every = [*chain(*logs.values())]
    groups = group_pairs(((e.format, e.agent, e.setting), e) for e in every)
    outcomes, episodes = _make_outcomes_table(groups), _make_episodes_table(groups)
    shown = [
        _drop_name_columns_with_one_value(table.drop_columns(_FILE_ONLY)) for table in (outcomes, episodes)
    ]
    twins: list[Table] = []
    if benchmark is not None:
        twins.append(
            make_table_of_benchmark_tasks_named_in_logs(every, benchmark.tasks(records.source), benchmark)
        )
    yield Analysis(
        [outcomes, episodes, *twins],
        [("logs", _draw_outcomes(groups))],
        [describe_log(path, episodes) for path, episodes in logs.items()],
        screen_tables=[
            *shown,
            *[table.select_columns(_TERMINAL_COLUMNS_OF_SAME_NAMED_TASKS) for table in twins if table.rows],
        ],
        facts={"outcomes": dict(Counter(episode.outcome.value for episode in every))},
        pages={"explorer.html": make_explorer_page(every, _COLORS)},
    )


def _drop_name_columns_with_one_value(table: Table) -> Table:
    rows = table.row_dicts()
    constant = [name for name in _NAMES if len({str(row[name]) for row in rows}) == 1]
    return table.drop_columns(constant[1:] if len(constant) == len(_NAMES) else constant)


def describe_log(path: Path, episodes: Sequence[LoggedEpisode]) -> str:
    """Return a sentence with the form and number of episodes of logs, and with properties that they lack."""
    unknown = Counter(name for episode in episodes for name in episode.unknown)
    missing = ", ".join([f"{name} ({number})" for name, number in unknown.items()])
    forms = ", ".join(dict.fromkeys(episode.format for episode in episodes))
    found = f"{path}: {forms}, {len(episodes):,} episode{'s' * (len(episodes) != 1)}"
    return f"{found}; not in the log: {missing}" if missing else found


@collect_rows_in_table(
    "outcomes", (*_NAMES, "episodes", *[outcome.value for outcome in EpisodeOutcome], "errors", "proven")
)
def _make_outcomes_table(groups: _Groups) -> Iterator[Row]:
    """Episodes by outcome.

    won, goal unmet: verdicts of the log's own grader, in its own world; not reproduced: the grader's replay
    did not reproduce the episode; nothing submitted: there was nothing to grade; not graded: no verdict.
    errors: actions that the world rejected; proven: percentage of errors whose kind is certain from the log.
    The kind of all other errors is "cannot tell".
    """
    for names, episodes in groups.items():
        outcomes = Counter(episode.outcome for episode in episodes)
        errors = [step for episode in episodes for step in episode.steps if step.is_error]
        proven = Rate(sum(step.kind is not None for step in errors), len(errors))
        yield (
            *names,
            len(episodes),
            *[outcomes[outcome] for outcome in EpisodeOutcome],
            len(errors),
            Estimate.from_rate(proven),
        )


@collect_rows_in_table("episodes", (*_NAMES, *_EPISODE_COLUMNS))
def _make_episodes_table(groups: _Groups) -> Iterator[Row]:
    """Episodes.

    first_error: the first action that the world rejected, counted from 1; kind: the kind of this error; best:
    the largest percentage of the goal's conditions that held at once; best_action: the first action after
    which best was reached; end: the percentage at the end; unseen: kinds of goal objects that no observation
    names; repeats: how often the most frequent pair of action and reply occurs; words: the agent's last
    words, or the last reply. A cell is empty if the log does not show its value.
    """
    for names, episodes in groups.items():
        for episode in episodes:
            error = episode.index_of_first_error
            step_of_best_goal_progress = episode.step_of_best_goal_progress
            kind = None if error is None else episode.steps[error].kind
            yield (
                *(*names, episode.task, episode.outcome.value, episode.ending.value),
                "" if error is None else CANNOT_TELL if kind is None else kind.value,
                ", ".join(episode.unseen),
                len(episode.steps) or episode.actions,
                None if error is None else error + 1,
                _to_percent(episode.best_goal_progress),
                None if step_of_best_goal_progress is None else step_of_best_goal_progress + 1,
                _to_percent(episode.progress),
                *(
                    episode.max_occurrences_of_action_reply_pair,
                    episode.seconds,
                    episode.calls,
                    episode.tokens,
                ),
                episode.words[:_MAX_WORDS_CHARACTERS],
            )


def _to_percent(share: float | None) -> float | None:
    return None if share is None else round(100 * share, 1)


def _draw_outcomes(groups: _Groups) -> Figure:
    """Draw a bar of outcomes for each group of episodes, and a mark for each episode that is not won.

    The mark is at the largest percentage of the goal's conditions that held at once.
    """
    figure = make_figure(2 * COLUMN, 1.1 + 0.4 * len(groups))
    left, right = figure.subplots(1, 2, sharey=True)
    for row, episodes in enumerate(groups.values()):
        counted, start = Counter(episode.outcome for episode in episodes), 0
        for outcome in filter(counted.get, EpisodeOutcome):
            left.barh(row, counted[outcome], 0.6, start, color=_COLORS[outcome], label=outcome.value)
            start += counted[outcome]
        for episode in episodes:
            if episode.best_goal_progress is not None and episode.outcome is not EpisodeOutcome.WON:
                right.plot(
                    100 * episode.best_goal_progress, row, "|", color=_COLORS[episode.outcome], markersize=11
                )
    labels = [wrap_label(", ".join(filter(None, names[1:])) or names[0]) for names in groups]
    left.set_yticks(range(len(groups)), labels=labels, fontsize=6.5)
    left.set_ylim(len(groups) - 0.5, -0.5)
    left.set_xlabel("episodes", fontsize=7, loc="right")
    right.set_xlim(-3, 103)
    right.set_xlabel("best moment of lost episodes, percent", fontsize=7, loc="right")
    right.grid(axis="x", color=RULE, linewidth=0.6)
    handles = dict(zip(*reversed(left.get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=3, frameon=False, fontsize=6.5)
    return figure


LOGS = Study(
    "logs",
    "Logs of other projects: outcomes of episodes, first errors, best moments.",
    choices=_EpisodeLogOptions,
    analyze=_analyze_logs,
)
