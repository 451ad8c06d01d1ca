"""``eai explain``: show an answer step by step, or list answers."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.explanation import (
    EXECUTED,
    GoalPartReport,
    StepReport,
    VerdictExplanation,
    map_missed_goals_to_similar_facts,
)
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT, describe_repair
from eai.abilities.reports import action_text
from eai.abilities.scorer import PlanScorer
from eai.abilities.verdict import RAISED, AnswerSpanKind, ErrorReport, PlanVerdict, Unreadable
from eai.agents.verdict import EpisodeVerdict, describe_goal_reachability
from eai.base.entry_points import load_from_extension
from eai.base.errors import EaiError, InputError, did_you_mean, find_enum_member
from eai.base.files import to_model_name, write_files_atomically
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.packs import is_stored
from eai.benchmarks.registry import list_benchmarks
from eai.benchmarks.suite import Suite, open_suite
from eai.cli.console import format_count, get_output_console, print_json, print_result_line
from eai.cli.logs import find_plugin_that_reads_log
from eai.cli.options import AsJson, DataFolder, make_flag, open_store
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.results.answer_files import find_benchmarks_of_runs
from eai.results.codec import record_to_json
from eai.results.record import NOT_ANSWERED, Record
from eai.results.records import read_records
from eai.results.runs import find_record_files
from eai.results.summary import find_answer_outcome
from eai.studies.report.explorer import make_film_file_name
from eai.tasks.planning import find_plan
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import Task
from eai.world.fault import NOT_EXECUTED, FaultKind

NOT_EXPLAINED = "the record has no explanation; score the answer with --explanations to get one"
NO_FAILURES = frozenset({AnswerOutcome.EXCLUDED, AnswerOutcome.SUCCESS})
SHOWN_WHOLE = 2
"""Maximum number of answers to one task that are shown step by step; more answers are listed."""


@dataclass(frozen=True, slots=True)
class _TaskInfoFromDataSet:
    """The data set's information about the task of a record.

    Attributes:
        instruction: Instruction of the task.
        gold: Steps of a plan that solves the task, as texts.
        source: Origin of the plan in `gold`, as a heading.
        untried_steps: Steps of the answer after the failed step, which were never tried.
        outlook: Result of a search about a failed answer, in sentences: whether the episode could still reach
            its goals, or the fewest edits that repair the plan.
    """

    instruction: str = ""
    gold: tuple[str, ...] = ()
    source: str = ""
    untried_steps: tuple[str, ...] = ()
    outlook: tuple[str, ...] = ()


_NOTHING_KNOWN = _TaskInfoFromDataSet()

_MAX_PART = 300
"""Maximum number of characters of each printed part of an answer's text."""


def _parse_outcome(name: str) -> AnswerOutcome:
    return find_enum_member(AnswerOutcome, name, "outcome")


def explain(
    records: Path,
    task: Annotated[str, typer.Argument()] = "",
    failed: bool = False,
    kind: Annotated[AnswerOutcome | None, make_flag(parser=_parse_outcome, metavar="KIND")] = None,
    model: str | None = None,
    limit: Annotated[int, make_flag(min=0)] = 20,
    film: Annotated[Path | None, make_flag(metavar="FILE")] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Show an answer step by step, with state changes and the reason of a failure, or list answers.

    If the data set is installed, the instruction, the untried steps and the data set's own plan are shown
    too. Nothing is fetched for this.

    Example: eai explain scores 27_2

    Example: eai explain runs --kind missing_step --model gpt-4o

    Options:
        records: A file records.jsonl, a folder with such files below it, or a log of another project.
        task: A task: its id, the beginning of its id, or words of its title.
        failed: Only failures; without TASK, list them.
        kind: Only answers with this outcome, such as missing_step.
        model: Only answers of this model.
        limit: Maximum number of listed answers; 0 for all.
        film: Write the execution of one answer as a GIF (extra 'physics'), into a file or a folder. The
            explorer of a report links to GIFs in its folder films.
    """
    every_record, log_plugin = _read_records_or_find_log_plugin(records)
    if log_plugin is not None:
        log_plugin.explain_log(
            records, task, failed=failed, kind=kind, agent=model, limit=limit, film=film, as_json=as_json
        )
        return
    chosen = _select_records_of_model(every_record, model)
    if task:
        chosen = _select_records_of_task(records, chosen, task)
    if kind is not None:
        chosen = [record for record in chosen if find_answer_outcome(record) is kind]
    elif failed:
        chosen = [record for record in chosen if find_answer_outcome(record) not in NO_FAILURES]
    if film is not None:
        _write_gif_of_execution(chosen, records, open_store(data), film)
    excluded = 0
    if not task and kind is None and not as_json:
        listed = [record for record in chosen if find_answer_outcome(record) is not AnswerOutcome.EXCLUDED]
        excluded, chosen = len(chosen) - len(listed), listed
    if as_json:
        print_json([record_to_json(record) for record in chosen])
    elif not chosen:
        print_result_line("no such answer")
    elif task and len({record.task_id for record in chosen}) == 1 and len(chosen) <= SHOWN_WHOLE:
        for record in chosen:
            print_record(
                get_output_console(), record, _read_task_info_from_data_set(record, records, open_store(data))
            )
    else:
        _print_answer_list(get_output_console(), chosen, limit or len(chosen))
    if excluded:
        print_result_line(f"{excluded} excluded from all rates (--kind excluded lists them)")


def _read_records_or_find_log_plugin(path: Path) -> tuple[list[Record], Any | None]:
    """Return the records (scored answers) at a path, or the plug-in that reads the log at this path.

    A plug-in reads logs of other projects.
    """
    try:
        return [each for file in find_record_files([path]) for each in read_records(file)], None
    except InputError:
        # plug-ins read logs of other projects; a folder with run.toml has eai's own logs
        plugin = None if (path / "run.toml").is_file() else find_plugin_that_reads_log(path)
        if plugin is None:
            raise
        return [], plugin


def _read_task_info_from_data_set(
    record: Record, records: Path, store: DataPackStore
) -> _TaskInfoFromDataSet:
    """Return the data set's information about a record's task.

    The result is empty if the data set is missing, or differs from the data of the record.
    """
    own = find_benchmarks_of_runs([records]).get(record.domain)
    if own is not None or (record.domain in list_benchmarks() and is_stored(store, record.domain)):
        with suppress(EaiError):
            suite = _open_suite_of_record(record, own or record.domain, store)
            task = suite.tasks.get(record.task_id)
            if task is not None and suite.data_sha256 == record.data_sha256:
                outlook = _describe_distance_to_success(suite, record)
                return _TaskInfoFromDataSet(
                    task.instruction,
                    *_find_solving_plan_and_origin(suite, task),
                    _list_steps_after_failure(suite, record),
                    outlook,
                )
    return _NOTHING_KNOWN


def _open_suite_of_record(record: Record, benchmark: Benchmark | str, store: DataPackStore) -> Suite:
    """Return the suite (ability in a benchmark) by which an answer was scored."""
    source = Source(store, errata=ErrataChoice.CURRENT if record.errata else ErrataChoice.NONE)
    return open_suite(benchmark, record.ability, record.protocol, source=source)


def _write_gif_of_execution(
    chosen: Sequence[Record], records: Path, store: DataPackStore, file: Path
) -> None:
    """Write an animated picture (GIF) of the execution of an answer.

    Raises:
        InputError: The number of chosen answers is not one, the execution of the answer is unknown, or the
            scene cannot be built.
        EaiError: A library for drawing is not installed.
    """
    if len(chosen) != 1:
        raise InputError(f"--film: expected one answer, found {len(chosen)}; give TASK and --model")
    (record,) = chosen
    benchmark = find_benchmarks_of_runs([records]).get(record.domain) or record.domain
    suite = _open_suite_of_record(record, benchmark, store)
    film: bytes = load_from_extension("rendered_pictures", "--film").make_film_of_answer(record, suite)
    write_files_atomically({file / make_film_file_name(record) if file.is_dir() else file: film})


def _find_solving_plan_and_origin(suite: Suite, task: Task) -> tuple[tuple[str, ...], str]:
    """Return a plan that solves a task, as texts of actions or subgoals, and a heading with its origin.

    Both are empty if answers to the ability are not plans.
    """
    if suite.ability is Ability.SUBGOAL_DECOMPOSITION:
        book = open_gold_answers(suite.benchmark, suite.ability, suite.source)
        return book[task.id].parts, "gold subgoals"
    if suite.ability is not Ability.ACTION_SEQUENCING:
        return (), ""
    if task.script:
        return tuple(action_text(action, task.scene) for action in task.script), "the data set's plan"
    plan = find_plan(task, Planner(suite.benchmark.domain)).plan or ()
    return tuple(action_text(action, task.scene) for action in plan), "a plan by eai/planner"


def _describe_distance_to_success(suite: Suite, record: Record) -> tuple[str, ...]:
    """Return sentences on the distance of a failed answer from success, such as edits that repair its plan.

    A search finds the distance if the record does not contain it.
    """
    verdict = record.verdict
    if find_answer_outcome(record) in NO_FAILURES or record.unanswered or record.experiment is not None:
        return ()
    look_back = suite.assess(record.task_id, record.response).analyze_failure
    known = verdict.repair if not isinstance(verdict, EpisodeVerdict) else verdict.outlook
    if known is None and look_back is not None:
        verdict = look_back(Limits().states if isinstance(verdict, EpisodeVerdict) else DEFAULT_EFFORT)
    if isinstance(verdict, EpisodeVerdict):
        return (describe_goal_reachability(verdict),)
    return () if verdict.repair is None else tuple(describe_repair(verdict.repair))


def _list_steps_after_failure(suite: Suite, record: Record) -> tuple[str, ...]:
    """Return the steps of a plan after the failed step."""
    verdict, scorer = record.verdict, suite.scorer(record.task_id)
    if record.explanation is None or not isinstance(verdict, PlanVerdict) or verdict.executable:
        return ()
    if verdict.error is not None and verdict.error.check == RAISED:
        return ()
    if not isinstance(scorer, PlanScorer):
        return ()
    plan = scorer.read(record.response)
    actions = None if isinstance(plan, Unreadable) else scorer.resolve_names(plan)
    if actions is None or isinstance(actions, ErrorReport):
        return ()
    tried = len(record.explanation.steps)
    return tuple(action_text(action, scorer.task.scene) for action in actions[tried:])


def print_record(console: Console, record: Record, background: _TaskInfoFromDataSet = _NOTHING_KNOWN) -> None:
    """Print a record (scored answer): the task, the answer's text, each step if known, and the verdict.

    Args:
        console: Console to print on.
        record: The record.
        background: Information of the data set about the task; empty if the data set is missing.
    """
    if record.is_cut_off:
        console.print(Text("cut off: the answer ended at a length limit", style="bold yellow"))
    titles = "".join([f"  {title}" for title in _list_title_if_it_differs_from_id(record)])
    heading = Text(f"{record.domain} {record.ability.value} {record.task_id}{titles}", style="bold")
    console.print(heading, soft_wrap=True)
    if background.instruction:
        _print_with_hanging_indent(
            console, "  ", Text(" ".join(background.instruction.split()), style="italic")
        )
    console.print(f"model {record.model}, protocol {record.protocol.value}", highlight=False)
    if record.experiment is not None:
        console.print(f"experiment {record.experiment.label}", highlight=False, soft_wrap=True)
    if record.unanswered is not None:
        console.print(Text(f"{NOT_ANSWERED}: {record.unanswered}", style="yellow"), soft_wrap=True)
    elif record.explanation is None:
        console.print(NOT_EXPLAINED, style="yellow", highlight=False, soft_wrap=True)
        error = record.verdict.error
        if error is not None:
            console.print(Text(f"{error.kind.value}: {error.detail}", style="red"))
    else:
        _print_explanation(console, record, record.explanation, background.untried_steps)
    for line in background.outlook:
        console.print(Text(line, style="yellow"), soft_wrap=True)
    if background.gold:
        console.print(
            Text(f"{background.source} ({format_count(len(background.gold), 'step')})", style="bold")
        )
        for number, step in enumerate(background.gold, 1):
            _print_with_hanging_indent(console, f"{number:3} ", Text(step, style="dim"))
    console.print(_format_verdict(record))


def _print_explanation(
    console: Console, record: Record, explanation: VerdictExplanation, untried_steps: Sequence[str]
) -> None:
    for note in explanation.notes:
        console.print(Text(note, style="yellow"))
    longest = max(
        (len(step) for step in (*(step.action for step in explanation.steps), *untried_steps)), default=0
    )
    width = min(longest, console.width - 15)
    for number, step in enumerate(explanation.steps, 1):
        _print_step(console, number, step, width)
    for number, action in enumerate(untried_steps, len(explanation.steps) + 1):
        _print_with_hanging_indent(console, f"{number:3} ", Text(f"{action:{width}}  not tried", style="dim"))
    if explanation.goals:
        remark = _format_count_of_met_goal_conditions(record)
        remark += ": none counts, as nothing was carried out" * _are_goals_missed_because_not_executed(
            record, explanation
        )
        console.print(Text("goals", style="bold").append(remark, style="not bold"))
    near = map_missed_goals_to_similar_facts(explanation)
    for goal in explanation.goals:
        mark, style = ("✓", "green") if goal.satisfied else ("✗", "red")
        _print_with_hanging_indent(console, f"  {mark} {goal.kind:8} ", Text(goal.goal, style=style))
        if goal.why:
            _print_with_hanging_indent(console, " " * 13, Text(goal.why, style="yellow"))
        if goal.goal in near:
            _print_with_hanging_indent(
                console, " " * 13, Text(f"got {', '.join(near[goal.goal])}", style="yellow")
            )
    _print_parsed_text(console, record)
    if explanation.parts:
        console.print(Text("temporal goal", style="bold"))
    for number, part in enumerate(explanation.parts):
        _print_goal_part(console, part, "never after that" if number else "never")


def _print_parsed_text(console: Console, record: Record) -> None:
    """Print how each part of the answer's text was read, unless all text was read without corrections."""
    spans = record.verdict.spans
    if not record.response or all(span.kind is AnswerSpanKind.READ for span in spans):
        return
    console.print(Text("the answer's text", style="bold"))
    for span in spans:
        words = shorten(record.response[span.start : span.end], _MAX_PART, placeholder=" ...")
        style = {
            AnswerSpanKind.UNREAD: "red",
            AnswerSpanKind.REPAIRED: "yellow",
            AnswerSpanKind.READ: "",
        }.get(span.kind, "dim")
        _print_with_hanging_indent(console, f"  {span.kind.value:9} ", Text(words, style=style))


def _format_count_of_met_goal_conditions(record: Record) -> str:
    share = record.verdict.partial if isinstance(record.verdict, PlanVerdict) else None
    if share is None:
        return ""
    return f", {share.numerator} of {format_count(int(share.denominator), 'condition')} met"


def _are_goals_missed_because_not_executed(record: Record, explanation: VerdictExplanation) -> bool:
    """Whether all goals count as missed because the answer was not executed, even goals true at the start."""
    error = record.verdict.error
    unread = isinstance(record.verdict, PlanVerdict) and error is not None and error.kind in NOT_EXECUTED
    return unread and not any(goal.satisfied for goal in explanation.goals)


def _print_step(console: Console, number: int, step: StepReport, width: int) -> None:
    indent = " " * 6
    line, below = Text(f"{step.action:{width}}  "), Text()
    if step.outcome == EXECUTED:
        line.append("ok", style="green")
        if step.reason:
            line.append(f", but {step.reason}", style="yellow")
    else:
        style = "yellow" if step.outcome == FaultKind.ADDITIONAL_STEP.value else "bold red"
        fault = f"{step.outcome}: {step.reason}" if step.reason else step.outcome
        fits = 4 + len(line) + len(fault) <= console.width
        (line if fits else below).append(fault, style=style)
    _print_with_hanging_indent(console, f"{number:3} ", line)
    if below:
        _print_with_hanging_indent(console, indent, below)
    if step.earlier:
        _print_with_hanging_indent(console, indent, Text(step.earlier, style="yellow"))
    for sign, facts, style in (("+", step.added, "green"), ("-", step.removed, "red")):
        for fact in _merge_texts_of_symmetric_facts(facts):
            _print_with_hanging_indent(console, f"{indent}{sign} ", Text(fact, style=f"dim {style}"))
    if step.hidden_changes:
        more = format_count(step.hidden_changes, "more change")
        console.print(Text(f"{indent}{more}, not shown", style="dim"))


def _print_with_hanging_indent(console: Console, label: str, text: Text) -> None:
    """Print a text after a label. Further lines of the text are indented by the width of the label."""
    for line in text.wrap(console, max(console.width - len(label), 20)):
        line.rstrip()
        console.print(Text(label, style=text.style).append_text(line))
        label = " " * len(label)


def _merge_texts_of_symmetric_facts(fact_texts: Sequence[str]) -> list[str]:
    """Merge two facts of a symmetric relation, such as next_to(a, b) and next_to(b, a), into one text."""
    merged: dict[str, str] = {}
    for fact in fact_texts:
        name, _, objects = fact.removesuffix(")").partition("(")
        back = f"{name}({', '.join(reversed(objects.split(', ')))})"
        if back in merged and back != fact:
            merged[back] = f"{back}, and back"
        else:
            merged[fact] = fact
    return list(merged.values())


def _print_goal_part(console: Console, part: GoalPartReport, missing_label: str) -> None:
    if part.met_after is not None:
        console.print(Text(f"  ✓ {part.part}  {part.first_met_time_text}", style="green"))
    else:
        lacking = (
            f"  {missing_label}: {', '.join(part.missing)}" if part.missing else "  was to come after that"
        )
        console.print(Text(f"  ✗ {part.part}{lacking}", style="red"))


def _print_answer_list(console: Console, records: Sequence[Record], limit: int) -> None:
    """Print one line for each answer: task, model, outcome and reason."""
    runs = {(each.domain, each.ability, each.protocol, each.model, each.experiment) for each in records}
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), show_header=False)
    table.add_column(overflow="fold", max_width=max(12, console.width * 2 // 5))
    table.add_column(overflow="fold")
    for record in records[:limit]:
        came_to = find_answer_outcome(record)
        where = [record.model, f"{record.domain} {record.ability.value}"] if len(runs) > 1 else []
        if where and record.experiment is not None:
            where.append(record.experiment.label)
        style = "green" if came_to is AnswerOutcome.SUCCESS else "red"
        table.add_row(
            Text.assemble(
                (record.task_id, "bold"),
                *(f"\n{text}" for text in (*_list_title_if_it_differs_from_id(record), *where)),
            ),
            Text.assemble(
                (f"{came_to.value}{', cut off' * record.is_cut_off}", style),
                f"\n{why}" if (why := _describe_failure(record)) else "",
            ),
        )
    console.print(table)
    shown = f", of which {limit} are shown (--limit 0: all)" if len(records) > limit else ""
    console.print(f"{format_count(len(records), 'answer')}{shown}", highlight=False)


def _list_title_if_it_differs_from_id(record: Record) -> list[str]:
    """Return a list with the title of a record's task; empty if the title is unknown or equals the id."""
    return [] if record.task is None or record.task.name == record.task_id else [record.task.name]


def _describe_failure(record: Record) -> str:
    """Return a short reason why an answer failed."""
    error = record.verdict.error
    if record.unanswered is not None:
        return record.unanswered
    if error is not None:
        noun = "subgoal" if record.ability is Ability.SUBGOAL_DECOMPOSITION else "step"
        place = "" if error.step is None else f"{noun} {error.step + 1}: "
        cause = f"{error.check}: " if error.kind is FaultKind.PARSING and error.check else ""
        return f"{place}{cause}{error.detail}"
    if (
        isinstance(record.verdict, EpisodeVerdict)
        and record.verdict.without_call
        and not record.verdict.turns
    ):
        return (
            f"a reply called no tool: {shorten(record.verdict.without_call, _MAX_PART, placeholder=' ...')}"
        )
    goals = record.explanation.goals if record.explanation is not None else ()
    missed = [goal.goal for goal in goals if not goal.satisfied]
    return f"not reached: {', '.join(missed)}" if missed else ""


def _format_verdict(record: Record) -> Text:
    verdict, failure = record.verdict, "failure"
    if isinstance(verdict, PlanVerdict):
        failure += ", executable" if verdict.executable else ", not executable"
    texts = {
        AnswerOutcome.EXCLUDED: (f"excluded: {verdict.excluded}", "bold yellow"),
        AnswerOutcome.NOT_ANSWERED: ("failure, no answer", "bold red"),
        AnswerOutcome.SUCCESS: ("success", "bold green"),
        AnswerOutcome.PARTLY_RIGHT: ("partly right", "bold yellow"),
    }
    return Text(*texts.get(find_answer_outcome(record), (failure, "bold red")))


def _select_records_of_model(records: Sequence[Record], model: str | None) -> list[Record]:
    """Return the records (scored answers) of a model, or all records if the model is None.

    Raises:
        InputError: The model has no record.
    """
    matches = [record for record in records if model is None or to_model_name(model) == record.model]
    if records and not matches:
        models = sorted({record.model for record in records})
        hint = did_you_mean(str(model), models)
        raise InputError(f"--model {model}: expected one of {', '.join(models)}{hint}")
    return matches


def _select_records_of_task(place: Path, records: Sequence[Record], task: str) -> list[Record]:
    """Return the records (scored answers) of the task with a given id, id prefix, or part of its title.

    The first of the three comparisons that matches a record counts.

    Raises:
        InputError: no record matches the text.
    """
    words = task.casefold()
    for matches in (
        [record for record in records if record.task_id == task],
        [record for record in records if record.task_id.startswith(task)],
        [record for record in records if record.task is not None and words in record.task.name.casefold()],
    ):
        if matches:
            return matches
    task_ids = {record.task_id for record in records}
    raise InputError(f"{place}: no record of task {task}{did_you_mean(task, sorted(task_ids))}")
