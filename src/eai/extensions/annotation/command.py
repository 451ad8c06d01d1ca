"""Derive goals and planning problems from demonstrations."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.reports import fact_text
from eai.base.errors import InputError, UserInterruptError, did_you_mean
from eai.base.files import to_file_name, write_files_atomically
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.cli.console import format_count, print_findings_and_exit, print_note, print_result, print_result_line
from eai.cli.options import AsJson, DataFolder, OfDomain, Planner, make_flag, open_data_source
from eai.cli.progress import show_scoring_progress
from eai.extensions.annotation import decisions as annotation
from eai.extensions.annotation.decisions import (
    Annotation,
    ChangesMadeByDemonstration,
    GoalPatternsOfDemonstrations,
    UserGoalDecisionsForTaskTitle,
)
from eai.extensions.annotation.problems import (
    SampledProblem,
    make_domain_with_operators,
    make_problem,
    replace_domains_by_common_domain,
)
from eai.logic.ltl_printer import format_ltl
from eai.pddl.model import PddlDomain
from eai.pddl.planners import make_planner
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import Task
from eai.tasks.task_files import write_task_file
from eai.tasks.task_lines import write_task_line

app = typer.Typer(no_args_is_help=True)

OfTitle = Annotated[
    str | None, make_flag("--title", help="Only demonstrations of this title.", metavar="TITLE")
]
DecisionFile = Annotated[
    Path, make_flag("--decisions", help="The TOML file of decisions, written by choose.", metavar="FILE")
]
Demonstrations = Annotated[
    Path | None,
    make_flag(
        "--demonstrations",
        help="An archive of further demonstrations, if the benchmark can read one.",
    ),
]
IgnoredPredicates = Annotated[
    list[str] | None,
    make_flag(
        "--without",
        help="Do not count this predicate. The command choose saves the option in the file.",
        metavar="PREDICATE",
    ),
]
_MAX_SHOWN_PATTERNS = 20
"""Maximum number of patterns that are printed without `--all`.

A pattern is a kind of change, such as ``ON(lamp)``, in demonstrations (recorded plans) for one task title.
"""


def _read_benchmark_and_demonstrations(
    domain: str, title: str | None, archive: Path | None, data: Path | None, without: Sequence[str] = ()
) -> tuple[Benchmark, Mapping[str, list[Task]]]:
    benchmark = find_benchmark(domain)
    with open_data_source(data, errata=ErrataChoice.NONE) as source:
        if archive is None:
            tasks: Mapping[str, Task] = benchmark.tasks(source)
        elif benchmark.data.open_demonstrations is None:
            raise InputError(
                f"--demonstrations: {benchmark.name} reads no archive of demonstrations; omit this option"
            )
        else:
            tasks = benchmark.data.open_demonstrations(archive, source.report)
    predicates = [predicate.name for predicate in benchmark.domain.vocabulary.predicates]
    for name in without:
        if name not in predicates:
            raise InputError(f"--without: {name!r} is no predicate{did_you_mean(name, predicates)}")
    return benchmark, annotation.group_by_title(tasks, title)


def _derive_goals_from_saved_user_decisions(
    benchmark: Benchmark, tasks_by_title: Mapping[str, list[Task]], decision_file: Path
) -> list[Annotation]:
    if not decision_file.exists():
        raise InputError(f"{decision_file}: no such file; eai data annotate choose writes it")
    _, titles_in_file = annotation.read_ignored_predicates_and_user_decisions(decision_file)
    unknown_titles = [name for name in titles_in_file if name not in tasks_by_title]
    if unknown_titles and len(tasks_by_title) > 1:
        hint = did_you_mean(unknown_titles[0], tuple(tasks_by_title))
        raise InputError(f"{decision_file}: no demonstration is called {unknown_titles[0]!r}{hint}")
    return list(annotation.derive_goals_from_demonstrations(tasks_by_title, benchmark.domain, titles_in_file))


@app.command(name="differences")
def print_state_changes_made_by_demonstrations(
    domain: OfDomain,
    title: OfTitle = None,
    without: IgnoredPredicates = None,
    count: bool = False,
    everything: Annotated[bool, make_flag("--all")] = False,
    demonstrations: Demonstrations = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Print the changes of each demonstration: all facts of changed objects, and new relations.

    With --count, print how many changes in the demonstrations of a title fit each pattern. A pattern names
    objects by class. In a pattern of a relation, the properties of one object may replace its class.

    Example: eai data annotate differences --domain virtualhome --title "Turn on light" --without NEXT_TO

    Options:
        count: Instead, count the changes that fit each pattern, for each title.
        everything: With --count, also print rare patterns.
    """
    benchmark, titles = _read_benchmark_and_demonstrations(domain, title, demonstrations, data, without or ())
    differences = {
        name: [annotation.find_changes_made_by_demonstration(task, benchmark.domain) for task in tasks]
        for name, tasks in titles.items()
    }
    if count:
        _print_goal_pattern_counts(differences, without or (), everything=everything, as_json=as_json)
        return
    facts = {
        difference.task.id: [
            fact_text(fact, difference.scene)
            for fact in difference.facts
            if fact.predicate not in (without or ())
        ]
        for of_title in differences.values()
        for difference in of_title
    }
    lines = [f"{task_id}: {', '.join(texts) or 'nothing'}" for task_id, texts in facts.items()]
    print_result(*lines, value=facts, as_json=as_json)


def _print_goal_pattern_counts(
    changes_by_title: Mapping[str, Sequence[ChangesMadeByDemonstration]],
    ignored_predicates: Sequence[str],
    *,
    everything: bool,
    as_json: bool,
) -> None:
    lines, counts = list[str](), dict[str, Json]()
    for name, of_title in changes_by_title.items():
        table = annotation.count_patterns(of_title, ignored_predicates)
        counts[name] = {str(pattern): times for pattern, times in table.items()}
        rows = table.most_common(None if everything else _MAX_SHOWN_PATTERNS)
        lines.append(f"{name}: {format_count(len(of_title), 'demonstration')}")
        lines += [f"{times:5} {pattern}" for pattern, times in rows]
        if len(rows) < len(table):
            lines.append(f"      and {len(table) - len(rows)} more (--all)")
    print_result(*lines, value=counts, as_json=as_json)


@app.command(name="choose")
def ask_user_to_choose_goal_patterns(
    domain: OfDomain,
    title: Annotated[str, make_flag(metavar="TITLE")],
    decisions: DecisionFile = Path("decisions.toml"),
    without: IgnoredPredicates = None,
    demonstrations: Demonstrations = None,
    data: DataFolder = None,
) -> None:
    """Choose the goals of a task title: keep or drop the changes that its demonstrations share.

    The changes are listed first, as patterns such as ON(lamp). A pattern that you keep becomes a goal of
    tasks with this title; a pattern that you drop does not. Commands are read from standard input, one per
    line, so they can also come from a file. Every decision is saved at once; the same command resumes after
    an interruption.

    Example: eai data annotate choose --domain virtualhome --title "Turn on light" --without NEXT_TO

    Options:
        title: The title of the demonstrations.
    """
    not_counted, saved = annotation.read_ignored_predicates_and_user_decisions(decisions)
    if without:
        not_counted = tuple(dict.fromkeys((*not_counted, *without)))
    benchmark, titles = _read_benchmark_and_demonstrations(domain, title, demonstrations, data, without or ())
    differences = [
        annotation.find_changes_made_by_demonstration(task, benchmark.domain) for task in titles[title]
    ]
    listing = GoalPatternsOfDemonstrations(differences, benchmark.domain, not_counted)
    print_result_line(f"{title}: {format_count(len(listing.differences), 'demonstration')}")
    print_result_line(annotation.HELP)
    _print_goal_candidates_and_undecided_patterns(listing, saved.get(title, UserGoalDecisionsForTaskTitle()))
    end_reason = _save_decisions_and_return_end_reason(decisions, saved, title, listing)
    print_result_line(f"{end_reason}; written to {decisions}")


def _save_decisions_and_return_end_reason(
    decision_file: Path,
    saved_decisions_by_title: Mapping[str, UserGoalDecisionsForTaskTitle],
    title: str,
    listing: GoalPatternsOfDemonstrations,
) -> str:
    """Read a user's commands, which keep or drop patterns for a task title, and save after each command.

    A pattern is a change, such as ``ON(lamp)``, that demonstrations (recorded plans) for the title make.

    Return the reason why no more commands are read.

    Raises:
        UserInterruptError: the user interrupted the command.
    """
    chosen = saved_decisions_by_title.get(title, UserGoalDecisionsForTaskTitle())
    before = list[UserGoalDecisionsForTaskTitle]()
    try:
        while True:
            annotation.write_user_goal_decisions_by_task_title(
                decision_file, listing.without, {**saved_decisions_by_title, title: chosen}
            )
            command = input("> " if sys.stdin.isatty() else "").strip()
            if command == "done":
                return "done"
            try:
                chosen = _apply_command(command, chosen, before, listing)
            except InputError as error:
                print_note(str(error))
            else:
                _print_goal_candidates_and_undecided_patterns(listing, chosen)
    except EOFError:
        return "the input ended"
    except KeyboardInterrupt:
        # The user may have interrupted the command before the last decision was written.
        annotation.write_user_goal_decisions_by_task_title(
            decision_file, listing.without, {**saved_decisions_by_title, title: chosen}
        )
        raise UserInterruptError(
            f"interrupted; every decision is in {decision_file}, and the same command resumes from here"
        ) from None


def _apply_command(
    command: str,
    chosen: UserGoalDecisionsForTaskTitle,
    earlier_decisions: list[UserGoalDecisionsForTaskTitle],
    listing: GoalPatternsOfDemonstrations,
) -> UserGoalDecisionsForTaskTitle:
    if not command:
        return chosen
    if command == "undo":
        if not earlier_decisions:
            raise InputError("undo: there is no earlier command")
        return earlier_decisions.pop()
    after = annotation.apply_user_command_to_decisions(command, chosen, listing)
    earlier_decisions.append(chosen)
    return after


def _print_goal_candidates_and_undecided_patterns(
    listing: GoalPatternsOfDemonstrations, decisions: UserGoalDecisionsForTaskTitle
) -> None:
    for number, candidate in enumerate(decisions.candidates, 1):
        texts = [" or ".join(map(str, entry)) for entry in candidate]
        met = sum(
            annotation.is_goal_template_met(candidate, difference) for difference in listing.differences
        )
        print_result_line(f"candidate {number}, met by {met}:")
        for text in texts:
            print_result_line(f"    {text}")
    rows = listing.find_numbers_of_undecided_patterns(decisions)
    for number in rows[:_MAX_SHOWN_PATTERNS]:
        pattern = listing.patterns_in_order_shown_to_user[number - 1]
        print_result_line(f"{number:4}  {pattern}  in {listing.demonstration_counts[pattern]}")
    if len(rows) > _MAX_SHOWN_PATTERNS:
        print_result_line(f"      and {len(rows) - _MAX_SHOWN_PATTERNS} rarer patterns")


@app.command(name="goals")
def print_or_write_goals_from_user_decisions(
    domain: OfDomain,
    decisions: DecisionFile = Path("decisions.toml"),
    title: OfTitle = None,
    out: Annotated[Path | None, make_flag(metavar="FILE")] = None,
    assigned: bool = False,
    checked: Annotated[bool, make_flag("--check")] = False,
    demonstrations: Demonstrations = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Derive each task's goals from the decisions about its title: print the goals, or write a task file.

    `eai data annotate choose` writes the decisions. They list candidates: possible meanings of a title. A
    task gets the goals of the first candidate that its demonstration meets. If the demonstration meets no
    candidate, the task is left out. With --check, exit status 2 if goals in the data set differ.

    Example: eai data annotate goals --domain virtualhome --decisions decisions.toml --title "Turn on light"

    Options:
        out: Write the tasks with these goals: FILE.jsonl.
        assigned: Instead, print the candidates that demonstrations meet.
        checked: Instead, print every task whose goals in the data set differ.
    """
    benchmark, titles = _read_benchmark_and_demonstrations(domain, title, demonstrations, data)
    annotations = _derive_goals_from_saved_user_decisions(benchmark, titles, decisions)
    if checked:
        print_findings_and_exit(
            list(annotation.check_goals(annotations)), "all goals follow from the decisions", as_json=as_json
        )
        return
    if assigned:
        print_result(
            *_format_demonstrations_per_goal_candidate(annotations),
            value={difference.task.id: candidate for difference, candidate, _ in annotations},
            as_json=as_json,
        )
        return
    annotations = [difference for difference in annotations if difference[2]]
    goals: dict[str, Json] = {
        difference.task.id: [format_ltl(goal.formula) for goal in of_task]
        for difference, _, of_task in annotations
    }
    lines = [f"{task_id}: {texts}" for task_id, texts in goals.items()]
    if out is not None:
        tasks = [replace(difference.task, goals=of_task) for difference, _, of_task in annotations]
        write_task_file(out, [write_task_line(task, domain, benchmark.domain) for task in tasks])
        lines = [f"{format_count(len(annotations), 'task')} written to {out}"]
    print_result(*lines, value=goals, as_json=as_json)


def _format_demonstrations_per_goal_candidate(annotations: Sequence[Annotation]) -> Iterator[str]:
    numbers = Counter((difference.task.title, candidate) for difference, candidate, _ in annotations)
    for (name, candidate), times in numbers.items():
        which = "no candidate" if candidate is None else f"candidate {candidate + 1}"
        yield f"{name}: {which}: {format_count(times, 'demonstration')}"


@app.command(name="problems", no_args_is_help=True)
def write_planning_problems(
    domain: OfDomain,
    out: Annotated[Path, make_flag()],
    conditions: Annotated[int, make_flag(min=1)] = 4,
    seed: int = 0,
    limit: Annotated[int | None, make_flag(min=1)] = None,
    planner: Planner = PlannerChoice.AUTO,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write one planning problem per task: some ground conditions of its goal that a planner can reach.

    If a goal can be met in several ways, one way is drawn. Then some conditions of this way are drawn, and
    drawn again if the planner cannot reach them. Exit status 1 if a task has no solvable problem.

    Example: eai data annotate problems --domain behavior --out problems --limit 5

    Options:
        out: Folder for the domain and the problems.
        conditions: Maximum number of conditions in a goal.
        seed: Seed of the draws.
        limit: Maximum number of tasks.
    """
    benchmark = find_benchmark(domain)
    with open_data_source(data) as source:
        tasks = benchmark.tasks(source)
        operators = _read_planning_domain(benchmark, source)
    judge = make_planner(planner, benchmark.data.planner_seconds)
    if judge is None:
        raise InputError("--planner none: choose a planner, as only solvable problems are kept")
    made: list[SampledProblem] = []
    chosen = [tasks[task_id] for task_id in list(tasks)[:limit]]
    with show_scoring_progress("planning", len(chosen), quiet=False) as report:
        for number, task in enumerate(chosen, 1):
            problem = make_problem(
                task, benchmark, judge, operators=operators, conditions=conditions, seed=seed
            )
            if problem is not None:
                made.append(problem)
            report(number)
    made = replace_domains_by_common_domain(made, benchmark)
    _write_problem_files(out, made)
    failed = [problem for problem in made if problem.outcome is not PlannerOutcome.SOLVED]
    line = f"{format_count(len(made) - len(failed), 'problem')} written to {out}"
    value: Json = {each.task_id: {"outcome": each.outcome.value, "draws": each.draws} for each in made}
    print_result(line, value=value, as_json=as_json)
    for each in failed:
        print_note(f"{each.task_id}: no solvable problem ({each.outcome.value}, {each.draws} draws)")
    if failed:
        raise typer.Exit(1)


def _read_planning_domain(benchmark: Benchmark, source: Source) -> PddlDomain | None:
    """Return the planning domain of the benchmark's data set, or None if the data set has no problems."""
    if benchmark.data.problem_of is None:
        return None
    library = next(iter(benchmark.operator_tasks(source).values())).domain
    return make_domain_with_operators(
        [text.write_pddl for text in library.operators.values()], library.header
    )


def _write_problem_files(folder: Path, problems: list[SampledProblem]) -> None:
    solved = [problem for problem in problems if problem.outcome is PlannerOutcome.SOLVED]
    texts = {folder / f"{to_file_name(problem.task_id)}.pddl": f"{problem.text}\n" for problem in solved}
    if problems:
        write_files_atomically({**texts, folder / "domain.pddl": f"{problems[0].domain}\n"})
