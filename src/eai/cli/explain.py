"""``eai explain``: one answer step by step."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.explanation import Explanation, PartReport, StepReport
from eai.abilities.record import NOT_ANSWERED, Record
from eai.abilities.verdict import PlanVerdict
from eai.cli.console import output
from eai.errors import InputError
from eai.metrics.breakdown import outcome
from eai.scoring.records import read_records
from eai.scoring.results import RECORDS
from eai.world.fault import FaultKind

NOT_EXPLAINED = "the record has no explanation; score the answer with --explanations to get one"


def explain(
    records: Annotated[Path, typer.Argument(help="A records.jsonl, or the folder it is in.")],
    task: Annotated[str, typer.Argument(help="The id of the task, say 27_2.")],
) -> None:
    """Show what became of one answer: each step, what it changed, the failing check and why.

    Example: eai explain scores 27_2
    """
    for record in _find(records, task):
        print_record(output(), record)


def print_record(console: Console, record: Record) -> None:
    """Print what a record says of its answer, step by step where it holds an explanation."""
    console.print(Text(f"{record.domain} {record.ability.value} {record.task_id}", style="bold"))
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
        _print_explanation(console, record.explanation)
    console.print(_verdict_text(record))


def _print_explanation(console: Console, explanation: Explanation) -> None:
    for note in explanation.notes:
        console.print(Text(note, style="yellow"))
    width = max((len(step.action) for step in explanation.steps), default=0)
    for number, step in enumerate(explanation.steps, 1):
        _print_step(console, number, step, width)
    if explanation.goals:
        console.print(Text("goals", style="bold"))
    for goal in explanation.goals:
        mark, style = ("✓", "green") if goal.satisfied else ("✗", "red")
        console.print(Text(f"  {mark} {goal.kind:8} {goal.goal}", style=style))
    if explanation.parts:
        console.print(Text("temporal goal", style="bold"))
    for part in explanation.parts:
        _print_part(console, part)


def _print_step(console: Console, number: int, step: StepReport, width: int) -> None:
    line = Text(f"{number:3} {step.action:{width}}  ")
    if step.outcome == "executed":
        line.append("ok", style="green")
        if step.reason:
            line.append(f", but {step.reason}", style="yellow")
    else:
        style = "yellow" if step.outcome == FaultKind.ADDITIONAL_STEP.value else "bold red"
        line.append(f"{step.outcome}: {step.reason}", style=style)
    console.print(line)
    indent = " " * 6
    if step.earlier:
        console.print(Text(f"{indent}{step.earlier}", style="yellow"))
    for sign, facts, style in (("+", step.added, "green"), ("-", step.removed, "red")):
        for fact in facts:
            console.print(Text(f"{indent}{sign} {fact}", style=f"dim {style}"))
    if step.hidden_changes:
        console.print(Text(f"{indent}{step.hidden_changes} more changes to other objects", style="dim"))


def _print_part(console: Console, part: PartReport) -> None:
    if part.met_after is not None:
        console.print(Text(f"  ✓ {part.part}  after step {part.met_after}", style="green"))
    else:
        lacking = f"  never: {', '.join(part.missing)}" if part.missing else ""
        console.print(Text(f"  ✗ {part.part}{lacking}", style="red"))


def _verdict_text(record: Record) -> Text:
    verdict = record.verdict
    match outcome(record):
        case AnswerOutcome.EXCLUDED:
            return Text(f"excluded: {verdict.excluded}", style="bold yellow")
        case AnswerOutcome.NOT_ANSWERED:
            return Text("failure, no answer", style="bold red")
        case AnswerOutcome.SUCCESS:
            return Text("success", style="bold green")
        case AnswerOutcome.PARTLY_RIGHT:
            return Text("partly right", style="bold yellow")
        case _ if isinstance(verdict, PlanVerdict):
            executed = "executable" if verdict.executable else "not executable"
            return Text(f"failure, {executed}", style="bold red")
        case _:
            return Text("failure", style="bold red")


def _find(path: Path, task: str) -> list[Record]:
    found = [record for record in read_records(_records_file(path)) if record.task_id == task]
    if not found:
        raise InputError(f"{_records_file(path)}: no record of task {task}")
    return found


def _records_file(path: Path) -> Path:
    return path / RECORDS if path.is_dir() else path
