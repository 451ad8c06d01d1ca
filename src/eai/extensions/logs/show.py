"""Show logs of other projects in `eai score` and `eai explain`, which find this module by its entry point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import typer
from rich.table import Table
from rich.text import Text

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import InputError, did_you_mean, require_extra
from eai.cli.analyze import write_analyses_of_study
from eai.cli.console import get_output_console, print_json, print_result, print_result_line
from eai.extensions.logs.episode import EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.explorer import NO_AGENT, describe_episode, name_result
from eai.extensions.logs.readers import is_log, read_logs
from eai.extensions.logs.study import LOGS, describe_log
from eai.studies.records import StudyRecords

__all__ = ("explain_log", "is_log", "show_logs")

_OPTIONS_FOR_LOGS = {"paths", "out", "as_json", "wide", "data"}
_STYLES = {"accepted": ("✓", "green"), "cannot tell": ("?", "yellow")}
_GRADED = (EpisodeOutcome.WON, EpisodeOutcome.GOAL_UNMET)


def show_logs(context: typer.Context, paths: Sequence[Path], out: Path | None, *, as_json: bool) -> None:
    """Print the outcomes in logs; with ``out``, also write tables and a page of episodes. Nothing is scored.

    Raises:
        InputError: a log is damaged, or an option for scoring is given.
    """
    for name in context.params.keys() - _OPTIONS_FOR_LOGS:
        if (source := context.get_parameter_source(name)) is not None and source.name == "COMMANDLINE":
            raise InputError(
                f"--{name.replace('_', '-')}: {paths[0]} is a log with its own score, which is not computed "
                "again; omit this option"
            )
    with require_extra("analysis", "logs need"):
        records = StudyRecords(tuple(paths), out or Path())
        values = list(write_analyses_of_study(LOGS, records, (), as_json=as_json, writes=out is not None))
    print_result(
        "nothing scored: outcomes are verdicts of the grader in each log, in its own world; they are no "
        "records and are not ranked. Answers to tasks of a benchmark need --domain and --ability",
        value=values,
        as_json=as_json,
    )


def explain_log(
    path: Path,
    task: str,
    *,
    failed: bool,
    kind: AnswerOutcome | None,
    agent: str | None,
    limit: int,
    film: Path | None,
    as_json: bool,
) -> None:
    """Print the episodes of a log as a list, or one episode step by step. Then describe the log.

    Args:
        path: the log, or a folder with logs only.
        task: the beginning of a task's name; empty for all tasks.
        failed: whether to leave out episodes with the outcome "won".
        kind: the kind of an episode's first error; None for all episodes.
        agent: name of the agent; None for all agents.
        limit: maximum number of listed episodes; 0 for all.
        film: file of a film that the user wants; must be None, because logs have no films.
        as_json: whether to print all values of the episodes as JSON.

    Raises:
        InputError: the log is damaged, or has no such task, or a film is wanted.
    """
    if film is not None:
        raise InputError(f"--film: expected records of eai, found a log, which has no films: {path}")
    episodes = read_logs([path])[path]
    tasks = list(dict.fromkeys(episode.task for episode in episodes))
    named = [task] if task in tasks else [name for name in tasks if name.startswith(task)]
    if not named:
        raise InputError(f"{path}: no episode of task {task}{did_you_mean(task, tasks)}")
    chosen = [
        episode
        for episode in episodes
        if episode.task in named
        and agent in (None, episode.agent)
        and (kind is None or _get_kind_of_first_error(episode) == kind.value)
        and not (failed and episode.outcome is EpisodeOutcome.WON)
    ]
    if as_json:
        print_json([{**asdict(e), "steps": [step._asdict() for step in e.steps]} for e in chosen])
        return
    if len(chosen) == 1 or (chosen and task and len(named) == 1):
        for episode in chosen:
            _print_episode(episode)
    else:
        _print_episode_list(chosen, limit or len(chosen))
    print_result_line(describe_log(path, episodes))


def _get_kind_of_first_error(episode: LoggedEpisode) -> str:
    if episode.index_of_first_error is None:
        return ""
    return name_result(episode.steps[episode.index_of_first_error])


def _print_episode(episode: LoggedEpisode) -> None:
    console, grid = get_output_console(), Table.grid(padding=(0, 1))
    names = [episode.agent or NO_AGENT, *filter(None, [episode.setting])]
    console.print(Text(episode.task, style="bold"))
    console.print(f"{episode.format} log, {', '.join(names)}", highlight=False)
    grid.add_column(justify="right")
    for number, step in enumerate(episode.steps, 1):
        result = name_result(step)
        mark, style = _STYLES.get(result, ("✗", "red"))
        reply = " ".join(step.feedback.split())
        line = reply if result == "accepted" else f"{result}: {reply}".removesuffix(": ")
        grid.add_row(str(number), Text(mark, style=style), Text(step.action))
        grid.add_row("", "", Text(line, style="dim" if result == "accepted" else style))
    console.print(grid)
    for line in describe_episode(episode):
        console.print(line, highlight=False)
    graded = ", by the log's own grader" if episode.outcome in _GRADED else ""
    console.print(Text(f"outcome: {episode.outcome.value}{graded}", style="bold"))


def _print_episode_list(episodes: Sequence[LoggedEpisode], limit: int) -> None:
    console = get_output_console()
    for episode in episodes[:limit]:
        names = "".join([f", {name}" for name in (episode.agent, episode.setting) if name])
        console.print(Text.assemble((episode.task, "bold"), names))
        console.print(f"  {episode.outcome.value}; {next(describe_episode(episode))}", highlight=False)
    shown = f", of which {limit} are shown (--limit 0: all)" if len(episodes) > limit else ""
    print_result_line(f"{len(episodes):,} episodes{shown}" if episodes else "no such episode")
