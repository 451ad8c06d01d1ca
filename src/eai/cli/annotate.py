"""``eai annotate``: from demonstrations to goals, one step after the other."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.task import Task
from eai.abilities.verdict import Json
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark
from eai.cli import annotate_problems
from eai.cli.console import DOMAIN_HELP, counted, data_progress, note, print_json, say, tell_findings
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.errors import InputError, InterruptError, did_you_mean
from eai.logic.ltl_printer import print_ltl
from eai.studies.annotation.decisions import (
    HELP,
    Annotation,
    Chosen,
    Decisions,
    Listing,
    annotate,
    by_title,
    check,
    decide,
    differences,
    read_decisions,
    write_decisions,
)
from eai.studies.annotation.demonstration import frequencies
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task_files import write_task_file
from eai.tasks.task_lines import written
from eai.world.state import Fact, Scene

app = typer.Typer(help="From demonstrations to goals and planning problems.", no_args_is_help=True)

OfDomain = Annotated[str, typer.Option("--domain", help=DOMAIN_HELP)]
OfTitle = Annotated[
    str | None, typer.Option("--title", metavar="TITLE", help="Demonstrations of this title alone.")
]
DecisionFile = Annotated[
    Path, typer.Option("--decisions", metavar="FILE", help="The decisions, a TOML file that choose writes.")
]
Demonstrations = Annotated[
    Path | None,
    typer.Option(
        "--demonstrations",
        help="An archive with more demonstrations than the benchmark has tasks, where it can read one.",
    ),
]
Without = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="PREDICATE", help="Do not count this; with choose, kept in the file."),
]
_SHOWN = 20
"""How many lines of a title are shown where nobody asked for all."""


@dataclass(frozen=True, slots=True)
class _Given:
    """A benchmark and its demonstrations by title."""

    benchmark: Benchmark
    titles: Mapping[str, list[Task]]


def _given(
    domain: str, title: str | None, place: Path | None, data: Path | None, without: Sequence[str] = ()
) -> _Given:
    with data_progress() as report:
        benchmark = find_benchmark(domain)
        tasks: Mapping[str, Task]
        if place is None:
            tasks = benchmark.tasks(Source(store(data), report, errata=ErrataChoice.NONE))
        elif benchmark.open_demonstrations is None:
            raise InputError(f"--demonstrations: {benchmark.name} reads no archive of demonstrations")
        else:
            tasks = benchmark.open_demonstrations(place, report)
    known = [predicate.name for predicate in benchmark.domain.vocabulary.predicates]
    for name in without:
        if name not in known:
            raise InputError(f"--without: {name!r} is no predicate{did_you_mean(name, known)}")
    return _Given(benchmark, by_title(tasks, title))


def _annotations(given: _Given, decisions: Path) -> list[Annotation]:
    if not decisions.exists():
        raise InputError(f"{decisions}: no such file; eai annotate choose writes it")
    known = read_decisions(decisions)
    strangers = [name for name in known.titles if name not in given.titles]
    if strangers and len(given.titles) > 1:
        hint = did_you_mean(strangers[0], tuple(given.titles))
        raise InputError(f"{decisions}: no demonstration is called {strangers[0]!r}{hint}")
    return list(annotate(given.titles, given.benchmark.domain, known))


@app.command(name="differences")
def show_differences(
    domain: OfDomain,
    title: OfTitle = None,
    without: Without = None,
    count: Annotated[
        bool, typer.Option("--count", help="Count what the demonstrations of a title share instead.")
    ] = False,
    everything: Annotated[bool, typer.Option("--all", help="With --count, show also what is rare.")] = False,
    demonstrations: Demonstrations = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Say what each demonstration changes: all of what changed objects are, and relations that are new.

    With --count, by class, and with one end by its properties, how many of a title share it.

    Example: eai annotate differences --domain virtualhome --title "Turn on light" --without NEXT_TO
    """
    given, left_out = _given(domain, title, demonstrations, data, without or ()), set(without or ())
    if count:
        _count(given, without or (), everything=everything, as_json=as_json)
        return
    found = [each for tasks in given.titles.values() for each in differences(tasks, given.benchmark.domain)]
    texts = {
        each.task.id: [_text(fact, each.scene) for fact in each.facts if fact.predicate not in left_out]
        for each in found
    }
    if as_json:
        print_json({task_id: list(facts) for task_id, facts in texts.items()})
        return
    for task_id, facts in texts.items():
        say(f"{task_id}: {', '.join(facts) or 'nothing'}")


def _text(fact: Fact, scene: Scene) -> str:
    return f"{fact.predicate}({', '.join(scene.objects[i].name for i in fact.arguments)})"


def _count(given: _Given, without: Sequence[str], *, everything: bool, as_json: bool) -> None:
    tables = {
        name: frequencies(differences(tasks, given.benchmark.domain), without)
        for name, tasks in given.titles.items()
    }
    if as_json:
        print_json(
            {name: {str(each): times for each, times in table.items()} for name, table in tables.items()}
        )
        return
    for name, table in tables.items():
        say(f"{name}: {counted(len(given.titles[name]), 'demonstration')}")
        rows = table.most_common(None if everything else _SHOWN)
        for pattern, times in rows:
            say(f"{times:5} {pattern}")
        if len(rows) < len(table):
            say(f"      and {len(table) - len(rows)} more (--all)")


@app.command()
def choose(
    domain: OfDomain,
    title: Annotated[str, typer.Option("--title", metavar="TITLE", help="Whose goal is to be decided.")],
    decisions: DecisionFile = Path("decisions.toml"),
    without: Without = None,
    demonstrations: Demonstrations = None,
    data: DataFolder = None,
) -> None:
    """Decide what a title means: what the demonstrations share is listed, and commands keep or drop it.

    Commands are read from standard input, one a line, so that they can come from a file, too. Every decision
    is in the file at once; the same command goes on where it was interrupted.

    Example: eai annotate choose --domain virtualhome --title "Turn on light" --without NEXT_TO
    """
    known = read_decisions(decisions)
    if without:
        known = replace(known, without=tuple(dict.fromkeys((*known.without, *without))))
    given = _given(domain, title, demonstrations, data, without or ())
    listing = Listing(
        differences(given.titles[title], given.benchmark.domain), given.benchmark.domain, known.without
    )
    say(f"{title}: {counted(len(listing.differences), 'demonstration')}")
    say(HELP)
    _show(listing, known.titles.get(title, Chosen()))
    left = _conversation(decisions, known, title, listing)
    say(f"{left}; written to {decisions}")


def _conversation(path: Path, known: Decisions, title: str, listing: Listing) -> str:
    """Take commands until there are no more; what is decided is in the file after each of them.

    Raises:
        InterruptError: the user ended it.
    """
    chosen, before = known.titles.get(title, Chosen()), list[Chosen]()
    try:
        while True:
            write_decisions(path, known.deciding(title, chosen))
            command = input("> " if sys.stdin.isatty() else "").strip()
            if command == "done":
                return "done"
            try:
                chosen = _after(command, chosen, before, listing)
            except InputError as error:
                note(str(error))
            else:
                _show(listing, chosen)
    except EOFError:
        return "the input ended"
    except KeyboardInterrupt:
        write_decisions(path, known.deciding(title, chosen))  # it may have come before the last was written
        told = f"interrupted; every decision is in {path}, and the same command resumes from here"
        raise InterruptError(told) from None


def _after(command: str, chosen: Chosen, before: list[Chosen], listing: Listing) -> Chosen:
    if not command:
        return chosen
    if command == "undo":
        if not before:
            raise InputError("nothing to take back")
        return before.pop()
    after = decide(command, chosen, listing)
    before.append(chosen)
    return after


def _show(listing: Listing, chosen: Chosen) -> None:
    """What is decided, and what is not."""
    for number, candidate in enumerate(chosen.candidates, 1):
        texts = [" or ".join(map(str, entry)) for entry in candidate.entries]
        met = sum(candidate.is_met(each) for each in listing.differences)
        say(f"candidate {number}, met by {met}:")
        for text in texts:
            say(f"    {text}")
    rows = listing.open(chosen)
    for number in rows[:_SHOWN]:
        pattern = listing.numbered[number - 1]
        say(f"{number:4}  {pattern}  in {listing.counts[pattern]}")
    if len(rows) > _SHOWN:
        say(f"      and {len(rows) - _SHOWN} rarer ones")


@app.command()
def goals(
    domain: OfDomain,
    decisions: DecisionFile = Path("decisions.toml"),
    title: OfTitle = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the tasks with these goals: FILE.jsonl.")
    ] = None,
    assigned: Annotated[
        bool, typer.Option("--assigned", help="Say instead which candidate each demonstration meets.")
    ] = False,
    checked: Annotated[
        bool, typer.Option("--check", help="Name instead every task whose goals do not follow.")
    ] = False,
    demonstrations: Demonstrations = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Say which goals follow from the decisions for each task, and write the tasks with them as a task file.

    A demonstration that meets no candidate is left out of the data set. With --check, exit status 2 if the
    goals of a task do not follow.

    Example: eai annotate goals --domain virtualhome --decisions decisions.toml --title "Turn on light"
    """
    given = _given(domain, title, demonstrations, data)
    found = _annotations(given, decisions)
    if checked:
        tell_findings(list(check(found)), "all goals follow from the decisions", as_json=as_json)
    elif assigned:
        _show_assigned(found, as_json=as_json)
    else:
        _show_goals(given, [each for each in found if each[2]], domain, out, as_json=as_json)


def _show_assigned(found: Sequence[Annotation], *, as_json: bool) -> None:
    if as_json:
        print_json({each.task.id: candidate for each, candidate, _ in found})
        return
    numbers = Counter((each.task.title, candidate) for each, candidate, _ in found)
    for (name, candidate), times in numbers.items():
        which = "no candidate" if candidate is None else f"candidate {candidate + 1}"
        say(f"{name}: {which}: {counted(times, 'demonstration')}")


def _show_goals(
    given: _Given, found: Sequence[Annotation], domain: str, out: Path | None, *, as_json: bool
) -> None:
    if out is not None:
        tasks = [replace(each.task, goals=goals) for each, _, goals in found]
        write_task_file(out, [written(task, domain, given.benchmark.domain) for task in tasks])
    goals: dict[str, Json] = {
        each.task.id: [print_ltl(goal.formula) for goal in of_task] for each, _, of_task in found
    }
    if as_json:
        print_json(goals)
    elif out is None:
        for task_id, texts in goals.items():
            say(f"{task_id}: {texts}")
    else:
        say(f"{counted(len(found), 'task')} written to {out}")


app.command("problems")(annotate_problems.problems)
