"""Rich consoles on which all commands print, and lines that several commands print."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from functools import partial
from importlib.util import find_spec
from textwrap import fill
from typing import TYPE_CHECKING

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from eai.abilities.protocol import Ability
from eai.base.errors import make_install_command, require_extra
from eai.base.files import escape_unprintable
from eai.benchmarks.registry import REFERENCES

if TYPE_CHECKING:
    from eai.base.json_value import Json
    from eai.benchmarks.benchmark import Benchmark
    from eai.benchmarks.suite import Suite
    from eai.tasks.source import DataMistake

DOMAIN_HELP = f"A benchmark: {REFERENCES}."
"""Help text of ``--domain``."""

BUILT_IN_ALONE = (
    "Fast Downward is not installed: the built-in search judges operators alone, and what it cannot decide "
    f"counts as not solved. For both: {make_install_command('planner')}"
)
"""Remark that Fast Downward is missing, so only the built-in search judges operators in answers."""


class _ConsoleEscapingControls(Console):
    """A console that escapes control characters in printed texts, so that no text controls the terminal."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Return the pieces of styled text to print, with control characters in them replaced."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=escape_unprintable(segment.text))


def get_output_console() -> Console:
    """Return the console on standard output, for results."""
    return _ConsoleEscapingControls(markup=False)


def get_error_console() -> Console:
    """Return the console on standard error, for notes, progress and errors."""
    return _ConsoleEscapingControls(stderr=True, markup=False)


def print_result_line(line: str) -> None:
    """Print a line of results. A terminal breaks it between words; other output has it unbroken."""
    _print_line(get_output_console(), line)


def print_markdown(text: str) -> None:
    """Print Markdown: formatted on a terminal, unchanged elsewhere."""
    console = get_output_console()
    if console.is_terminal:
        from rich.markdown import Markdown

        console.print(Markdown(text))
    else:
        print_result_line(text)


def print_note(line: str) -> None:
    """Print a note on standard error. A terminal breaks it between words."""
    _print_line(get_error_console(), line)


def _print_line(console: Console, line: str) -> None:
    """Print a text. A path longer than a line is not broken, so that it can be copied."""
    if console.is_terminal:
        parts = (
            fill(part, console.width, break_long_words=False, break_on_hyphens=False)
            for part in line.split("\n")
        )
        line = "\n".join(parts)
    console.print(line, markup=False, highlight=False, soft_wrap=True)


def print_json(value: Json) -> None:
    """Print a result as JSON on standard output."""
    print(json.dumps(value, indent=2))


def print_result(*lines: str, value: Json, as_json: bool) -> None:
    """Print a result as lines, or as JSON."""
    if as_json:
        print_json(value)
    else:
        for line in lines:
            print_result_line(line)


_SHOWN = 5
"""Maximum number of findings that are listed for one file. Further findings are only counted."""


def print_findings_and_exit(findings: Sequence[DataMistake], message_if_none: str, *, as_json: bool) -> None:
    """Print the findings of a check, the first few of each file, and end with status 2.

    The number of further findings of a file is printed, too.

    Args:
        findings: the findings.
        message_if_none: the text to print without findings.
        as_json: whether all findings are printed as JSON.
    """
    if as_json:
        print_json([{"place": each.place, "problem": each.problem} for each in findings])
    else:
        for place in dict.fromkeys(finding.place for finding in findings):
            problems = [finding.problem for finding in findings if finding.place == place]
            more = len(problems) - _SHOWN
            lines = problems if more <= 1 else [*problems[:_SHOWN], f"and {more:,} more (--json lists all)"]
            for line in lines:
                print_result_line(f"{place}: {line}")
        if not findings:
            print_result_line(message_if_none)
    if findings:
        raise typer.Exit(2)


def select_default_abilities(benchmark: Benchmark, abilities: Iterable[Ability]) -> list[Ability]:
    """Return the abilities without those that run in the benchmark only if ``--ability`` names them.

    A note is printed for each ability that is left out.
    """
    abilities, reasons = list(abilities), benchmark.data.only_by_name
    for each in abilities:
        if each in reasons:
            print_note(f"{benchmark.name}: no {each}, as {reasons[each]}; --ability {each} asks it")
    return [each for each in abilities if each not in reasons]


def print_note_if_planner_missing(suites: Sequence[Suite]) -> None:
    """Print a note on standard error, once, if operators in answers are judged without Fast Downward.

    The note is printed if Fast Downward is not installed, and no option chooses a planner.
    """
    from eai.pddl.planning import PlannerChoice

    asked = {suite.source.planner for suite in suites if suite.ability is Ability.TRANSITION_MODELING}
    if PlannerChoice.AUTO in asked:
        from eai.pddl.planners import resolve_automatic_choice

        if resolve_automatic_choice(PlannerChoice.AUTO) is PlannerChoice.BUILT_IN:
            print_note(BUILT_IN_ALONE)


inspect_needed = partial(require_extra, "run", "model runs and their logs need")
"""Context in which Inspect must be installed; raises EaiError if it is missing."""


def require_inspect_package() -> None:
    """Raise EaiError if Inspect is not installed, before a command fetches data.

    Raises:
        EaiError: Inspect is not installed.
    """
    with inspect_needed():
        if find_spec("inspect_ai") is None:
            raise ModuleNotFoundError(name="inspect_ai")


def format_count(number: int, noun: str) -> str:
    """Return a number with its noun: ``1 task``, ``1,000 tasks``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def format_dollars(amount: float) -> str:
    """Return an amount in dollars as text: with two digits from one dollar on, with more digits below one."""
    return f"${amount:.2f}" if amount >= 1 else f"${amount:.4f}"
