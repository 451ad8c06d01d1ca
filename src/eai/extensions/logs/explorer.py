"""Make an explorer page of logged episodes. Such a page shows no answers that `eai` has scored."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from eai.abilities.explanation import StepReport, parse_statement
from eai.extensions.logs.episode import CANNOT_TELL, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.studies.report.explorer import ExplorerPageData, build_explorer_page

NO_AGENT = "agent not named"


def describe_episode(episode: LoggedEpisode) -> Iterator[str]:
    """Yield lines on the first error, goal conditions met, the end, missing data and the last message."""
    error = episode.index_of_first_error
    if error is not None:
        yield f"first error: action {error + 1}, {name_result(episode.steps[error])}"
    else:
        seen = bool(episode.steps) and all(step.accepted for step in episode.steps)
        yield f"first error: {'none' if seen else CANNOT_TELL}"
    best = _format_percent(episode.best_goal_progress)
    if episode.best_goal_progress is not None:
        after = (
            ""
            if episode.step_of_best_goal_progress is None
            else f" after action {episode.step_of_best_goal_progress + 1}"
        )
        best = f"at best {best}{after}, at the end {_format_percent(episode.progress)}"
    yield f"goal conditions met: {best}"
    yield f"end: {episode.ending.value}"
    if episode.unknown:
        yield f"not in the log: {', '.join(episode.unknown)}"
    if episode.words:
        yield f"last message: {' '.join(episode.words.split())}"


def _format_percent(share: float | None) -> str:
    return CANNOT_TELL if share is None else f"{100 * share:.3g} %"


def name_result(step: LoggedStep) -> str:
    """Return the result of an action: accepted, its kind of error, or "cannot tell"."""
    if step.accepted is False:
        return f"{CANNOT_TELL} which kind" if step.kind is None else step.kind.value
    return "accepted" if step.accepted else CANNOT_TELL


def make_explorer_page(episodes: Iterable[LoggedEpisode], colors: Mapping[EpisodeOutcome, str]) -> str:
    """Return an HTML page on which a reader can explore episodes.

    Args:
        episodes: the episodes.
        colors: colours of all outcomes, success first.
    """
    data = ExplorerPageData(
        outcomes={_replace_blanks_by_underscores(outcome.value): color for outcome, color in colors.items()}
    )
    for episode in episodes:
        index, error = episode.index_of_first_error, None
        if index is not None:
            step = episode.steps[index]
            error = (_replace_blanks_by_underscores(name_result(step)), index, step.feedback)
        steps = map(_make_step_report, episode.steps, (None, *episode.steps))
        protocol = f"{episode.format}'s own, {episode.setting}"
        data.add_logged_episode(
            (episode.format, protocol.removesuffix(", "), episode.agent or NO_AGENT),
            episode.task,
            _replace_blanks_by_underscores(episode.outcome.value),
            error=error,
            lines=[*describe_episode(episode)][0 if error is None else 1 :],
            steps=steps,
        )
    return "".join(build_explorer_page(data.format_data_as_base64_lines()))


def _make_step_report(step: LoggedStep, before: LoggedStep | None) -> StepReport:
    is_new = step.progress is not None and (before is None or before.progress != step.progress)
    progress = f"{_format_percent(step.progress)} of the goal's conditions hold" if is_new else ""
    name = _replace_blanks_by_underscores(name_result(step))
    return StepReport(step.action, name, step.feedback, progress, call=parse_statement(step.action))


def _replace_blanks_by_underscores(text: str) -> str:
    return text.replace(" ", "_")
