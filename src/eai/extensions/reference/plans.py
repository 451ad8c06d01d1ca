"""Explain how eai-eval 1.0.5 (the paper's package) misreads plans.

The package eai-eval collects all text that looks like a step and ignores the rest. So ``"STANDUP": []`` is
lost, and steps in a model's reasoning count. Explanations list the steps that eai-eval loses or adds. They
also give the verdict under the protocol ``strict``, which follows the paper's text. The documentation of the
protocols calls this difference `lossy_reading`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from difflib import SequenceMatcher

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.declaration import get_declaration
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.scorer import Assessment
from eai.abilities.verdict import Unreadable, Verdict

MAX_LISTED_STEPS = 5
"""Maximum number of steps that a note in an explanation lists."""


def add_notes_on_strict_protocol(
    assessment: Assessment,
    answer: str,
    notation: PlanNotation,
    make_strict_scorer: Callable[[], ActionSequencingScorer],
) -> Assessment:
    """Return the assessment; its explanation has notes if eai-eval and ``strict`` read different steps.

    The protocol ``strict`` follows the paper's text. The notes list the steps that differ, and state the
    verdict by ``strict``. The explanation is computed on request.

    Args:
        assessment: the assessment by ``eai-1.0.5``, the rules of the paper's published package, eai-eval.
        answer: text of the answer.
        notation: the notation with which eai-eval reads the answer.
        make_strict_scorer: makes the scorer of the task under ``strict``.
    """

    def make_explanation_with_strict_protocol_notes() -> VerdictExplanation:
        explanation, strict = assessment.explain(), make_strict_scorer()
        differences = _describe_misread_steps(
            _read_steps(notation, answer), _read_steps(strict.notation, answer)
        )
        notes = [f"lossy_reading: {difference}" for difference in differences]
        if notes:
            notes.append(
                f"{Protocol.STRICT}, which passes over nothing: {_describe_outcome(strict.score(answer))}"
            )
        return replace(explanation, notes=(*explanation.notes, *notes))

    return Assessment(assessment.verdict, make_explanation_with_strict_protocol_notes)


def _read_steps(notation: PlanNotation, text: str) -> list[str] | Unreadable:
    plan = notation.read(text)
    if isinstance(plan, Unreadable):
        return plan
    return [
        f"{notation.to_operator_name(step.action)}({', '.join(map(str, step.objects))})"
        for step in plan.steps
    ]


def _describe_misread_steps(
    steps_read: list[str] | Unreadable, steps_written: list[str] | Unreadable
) -> Iterator[str]:
    if isinstance(steps_read, Unreadable):
        if not isinstance(steps_written, Unreadable):
            yield f"none of {len(steps_written)} steps is seen"
        return
    if isinstance(steps_written, Unreadable):
        yield f"what is no step is passed over; steps that are seen: {len(steps_read)}"
        return
    matcher = SequenceMatcher(None, steps_written, steps_read, autojunk=False)
    edits = [edit for edit in matcher.get_opcodes() if edit[0] != "equal"]
    dropped = [
        f"step {i + 1}, {steps_written[i]}" for _, start, end, _, _ in edits for i in range(start, end)
    ]
    added = [steps_read[i] for _, _, _, start, end in edits for i in range(start, end)]
    if dropped:
        yield f"not seen: {_format_steps(dropped)}"
    if added:
        yield f"seen, but no step of the plan: {_format_steps(added)}"


def _format_steps(steps: Sequence[str]) -> str:
    more = [f"{len(steps) - MAX_LISTED_STEPS} more"] if len(steps) > MAX_LISTED_STEPS else []
    return "; ".join([*steps[:MAX_LISTED_STEPS], *more])


def _describe_outcome(verdict: Verdict) -> str:
    error = verdict.error
    if error is not None:
        at = "" if error.step is None else f" at step {error.step + 1}"
        return f"{error.kind.value}{at}, {error.detail}"
    return get_declaration(Ability.ACTION_SEQUENCING).outcome(verdict).value
