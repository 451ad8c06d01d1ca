"""Shared by all commands: consoles, and lines that many of them print."""

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
from eai.base.errors import install_command, require_extra
from eai.base.files import escape_unprintable
from eai.benchmarks.registry import REFERENCES

if TYPE_CHECKING:
    from eai.base.json_value import Json
    from eai.benchmarks.benchmark import Benchmark
    from eai.benchmarks.suite import Suite
    from eai.tasks.source import Finding

DOMAIN_HELP = f"A benchmark: {REFERENCES}."
"""The help of ``--domain``."""

BUILT_IN_ALONE = (
    "Fast Downward is not installed: the built-in search judges operators alone, and what it cannot decide "
    f"counts as not solved. For both: {install_command('planner')}"
)
"""The remark where the authority on operators is missing."""


class _SafeConsole(Console):
    """A console on which no text that is printed controls the terminal; styles do."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """The segments of what is printed; of those that are text, what can be shown."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=escape_unprintable(segment.text))


def output() -> Console:
    """Where results go."""
    return _SafeConsole(markup=False)


def errors() -> Console:
    """Where everything else goes."""
    return _SafeConsole(stderr=True, markup=False)


def say(line: str) -> None:
    """Print a line of a command's results, as it stands; on a terminal it is broken between words."""
    _print(output(), line)


def print_markdown(text: str) -> None:
    """Print Markdown as it stands; on a terminal it is set."""
    console = output()
    if console.is_terminal:
        from rich.markdown import Markdown

        console.print(Markdown(text))
    else:
        say(text)


def note(line: str) -> None:
    """Print a line about how a command found it, on standard error, likewise."""
    _print(errors(), line)


def _print(console: Console, line: str) -> None:
    """A path that is longer than a line is left to the terminal, from which it can be copied whole."""
    if console.is_terminal:
        parts = (
            fill(part, console.width, break_long_words=False, break_on_hyphens=False)
            for part in line.split("\n")
        )
        line = "\n".join(parts)
    console.print(line, markup=False, highlight=False, soft_wrap=True)


def print_json(value: Json) -> None:
    """Print what a command found as JSON on standard output."""
    print(json.dumps(value, indent=2))


def tell(*lines: str, value: Json, as_json: bool) -> None:
    """Print what a command made: in lines, or as JSON."""
    if as_json:
        print_json(value)
    else:
        for line in lines:
            say(line)


_SHOWN = 5
"""How many findings of one file are listed before the rest is counted."""


def tell_findings(findings: Sequence[Finding], fine: str, *, as_json: bool) -> None:
    """Print what a check found, the first few of each place and how many more, and end with status 2.

    Args:
        findings: what it found.
        fine: what there is to say if that is nothing.
        as_json: print all of it as JSON.
    """
    if as_json:
        print_json([{"place": each.place, "problem": each.problem} for each in findings])
    else:
        for place in dict.fromkeys(finding.place for finding in findings):
            problems = [finding.problem for finding in findings if finding.place == place]
            more = len(problems) - _SHOWN
            lines = problems if more <= 1 else [*problems[:_SHOWN], f"and {more:,} more (--json lists all)"]
            for line in lines:
                say(f"{place}: {line}")
        if not findings:
            say(fine)
    if findings:
        raise typer.Exit(2)


def asked_by_default(benchmark: Benchmark, abilities: Iterable[Ability]) -> list[Ability]:
    """The abilities that are asked of a benchmark where none is named; says why others are left out."""
    abilities, reasons = list(abilities), benchmark.data.only_by_name
    for each in abilities:
        if each in reasons:
            note(f"{benchmark.name}: no {each}, as {reasons[each]}; --ability {each} asks it")
    return [each for each in abilities if each not in reasons]


def note_planner(suites: Sequence[Suite]) -> None:
    """Say on standard error, once, if operators are judged without Fast Downward because it is not there."""
    from eai.pddl.planning import PlannerChoice

    asked = {suite.source.planner for suite in suites if suite.ability is Ability.TRANSITION_MODELING}
    if PlannerChoice.AUTO in asked:
        from eai.pddl.planners import resolve_choice

        if resolve_choice(PlannerChoice.AUTO) is PlannerChoice.BUILT_IN:
            note(BUILT_IN_ALONE)


inspect_needed = partial(require_extra, "run", "model runs and their logs need")
"""Within it, Inspect is needed; raises EaiError where it is not installed."""


def need_inspect() -> None:
    """Say at once that a command needs Inspect, before anything is fetched for it.

    Raises:
        EaiError: it is not installed.
    """
    with inspect_needed():
        if find_spec("inspect_ai") is None:
            raise ModuleNotFoundError(name="inspect_ai")


def counted(number: int, noun: str) -> str:
    """A number of things: ``1 task``, ``1,000 tasks``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def dollars(amount: float) -> str:
    """An amount of money, to the cent from a dollar on and finer below."""
    return f"${amount:.2f}" if amount >= 1 else f"${amount:.4f}"
