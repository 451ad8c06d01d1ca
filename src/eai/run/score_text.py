"""What a score of Inspect's says in words: a record's explanation in Markdown, which its viewer shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.abilities.declaration import AnswerOutcome, label_of
from eai.abilities.explanation import Explanation, PartReport, StepReport
from eai.abilities.record import Record
from eai.results.breakdown import outcome


def explained(record: Record) -> str:
    """What an answer came to and why; step by step where the record has an explanation."""
    explanation = record.explanation or Explanation()
    sections = (
        ("", [f"- {note}" for note in explanation.notes]),
        ("Steps", [f"{number}. {_step(step)}" for number, step in enumerate(explanation.steps, 1)]),
        ("Goals", [f"- {_mark(goal.satisfied)} {goal.kind} `{goal.goal}`" for goal in explanation.goals]),
        ("Temporal goal", [f"- {_part(part, i)}" for i, part in enumerate(explanation.parts)]),
    )
    return "\n\n".join([f"**{_headline(record)}**", *(_section(*each) for each in sections if each[1])])


def _headline(record: Record) -> str:
    verdict, came_to = record.verdict, outcome(record)
    if came_to is AnswerOutcome.EXCLUDED:
        return f"Excluded: {verdict.excluded}"
    label = label_of(came_to.value)
    if came_to is AnswerOutcome.NOT_ANSWERED:
        return f"{label}: {record.unanswered}"
    if verdict.error is None or came_to is AnswerOutcome.SUCCESS:
        return label
    return f"{label}: {verdict.error.detail}"


def _section(title: str, lines: Sequence[str]) -> str:
    return "\n".join([f"{title}\n", *lines] if title else lines)


def _step(step: StepReport) -> str:
    return f"`{step.action}`: {'; '.join(_of_step(step))}"


def _of_step(step: StepReport) -> Iterator[str]:
    yield f"{label_of(step.outcome).lower()}, {step.reason}" if step.reason else step.outcome
    if step.earlier:
        yield step.earlier
    for sign, facts in (("+", step.added), ("-", step.removed)):
        yield from (f"{sign} `{fact}`" for fact in facts)
    if step.hidden_changes:
        yield f"{step.hidden_changes} more change{'' if step.hidden_changes == 1 else 's'}, not shown"


def _part(part: PartReport, number: int) -> str:
    if part.met_after is not None:
        return f"✓ `{part.part}`, {part.when}"
    never = "never after that" if number else "never"
    lacking = f", {never}: {', '.join([f'`{text}`' for text in part.missing])}" if part.missing else ""
    return f"✗ `{part.part}`{lacking}"


def _mark(satisfied: bool) -> str:
    return "✓" if satisfied else "✗"
