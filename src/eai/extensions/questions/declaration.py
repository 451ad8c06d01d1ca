"""World-model questions as a registered ability: it is asked of the questions in a file, not of tasks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

from eai.abilities.declaration import (
    AbilityDeclaration,
    AbilityWorld,
    AnswerOutcome,
    Interaction,
    MetricColumn,
    QuestionAndAnswer,
    counts_outcome,
    error_outcome,
    label_of,
)
from eai.abilities.explanation import Explanation, repair_notes
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import EMPTY_SHARE, Confusion, ErrorReport, Verdict, confusion_shares, share_of_one
from eai.extensions.questions.question import Form, Kind, Question, gold_text, grade, read_questions
from eai.extensions.questions.shortcuts import GUESS, SHORTCUTS, guesses_of
from eai.tasks.share import Share
from eai.tasks.source import TaskSet
from eai.world.fault import FaultKind

DEPTHS = {"1": 1, "2-3": 2, "4-7": 4, "8+": 8}
"""How many actions questions of a column are about at least, fewer than those of the next."""

WAYS = (GUESS, *SHORTCUTS)
"""How answers are had without knowing the world."""


class _AskedQuestion(NamedTuple):
    """A question of a file, and how often guessing hits it: at random, or with the most common answer."""

    question: Question
    guess: float


_NONE = Confusion(0, 0, 0)


@dataclass(frozen=True, slots=True)
class _QuestionVerdict(Verdict):
    """How right an answer to a question is, with what comparing and tabulating need of the question.

    Attributes:
        success: whether it is right in all that is asked; without an answer it is not.
        counts: parts that are right, that are wrong, and that are missed; where any of several is wanted, no
            more than one is missed.
        kind: what is asked about.
        form: how an answer is given.
        depth: how many actions there are to think of.
        gold: the right answers.
        chances: how much of it guessing and each shortcut get right, by name.
    """

    success: bool = False
    counts: Confusion = _NONE
    kind: Kind | None = None
    form: Form | None = None
    depth: int = 0
    gold: tuple[str, ...] = ()
    chances: Mapping[str, float] = field(default_factory=dict)


class _QuestionScorer(Scorer):
    """Scores the answers to a question."""

    def __init__(self, asked: _AskedQuestion) -> None:
        self._question, self._guess = asked

    def assess(self, text: str) -> Assessment:
        """The verdict; an answer that cannot be read is wrong."""
        question, graded = self._question, grade(self._question, text)
        error = ErrorReport(FaultKind.PARSING, None, f"there is no answer of the form {question.form.value}")
        verdict = _QuestionVerdict(
            error=None if graded.readable else error,
            repairs=graded.repairs,
            success=graded.exact,
            counts=graded.counts,
            kind=question.kind,
            form=question.form,
            depth=question.depth,
            gold=question.answer,
            chances={way: question.shortcuts.get(way, self._guess) for way in WAYS},
        )
        return Assessment(verdict, partial(_explanation, question, graded.repairs))


def _explanation(question: Question, repairs: Sequence[str]) -> Explanation:
    wanted = f"right is {question.accept} of {', '.join(question.answer)}"
    return Explanation(notes=(wanted, *repair_notes(repairs)))


def contributions(verdict: _QuestionVerdict) -> dict[str, Share]:
    """The contributions of one answer to each rate.

    It is right or not among all, among those of its kind and of its form, and of each kind among those of its
    depth. ``chance``: what guessing and each shortcut would have got right. F1 is that of the parts of
    answers in open form.
    """
    right = share_of_one(verdict.success)
    is_open = verdict.form is Form.OPEN
    depth = next((name for name, least in reversed(DEPTHS.items()) if least <= verdict.depth), "")
    return {
        "right": right,
        **{kind.value: right if kind is verdict.kind else EMPTY_SHARE for kind in Kind},
        **{f"form.{form.value}": right if form is verdict.form else EMPTY_SHARE for form in Form},
        "f1": confusion_shares("", verdict.counts)[".f1"] if is_open else EMPTY_SHARE,
        "parsing": share_of_one(verdict.error is not None),
        **{f"chance.{way}": Share(verdict.chances.get(way, 0.0), 1) for way in WAYS},
        **{
            f"{kind.value}.depth.{name}": right if (kind, name) == (verdict.kind, depth) else EMPTY_SHARE
            for kind in Kind
            for name in DEPTHS
        },
        **{
            f"{kind.value}.chance.{way}": Share(verdict.chances[way], 1)
            if kind is verdict.kind
            else EMPTY_SHARE
            for kind in Kind
            for way in WAYS
        },
    }


def outcome(verdict: _QuestionVerdict) -> AnswerOutcome:
    """The outcome of an answer."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return error_outcome(verdict) or counts_outcome(verdict.counts, enough=False)


def alike(one: _QuestionVerdict, other: _QuestionVerdict) -> bool:
    """Whether two verdicts are on the same question, be it with the rules or without."""
    return (one.kind, one.form, one.depth, one.gold) == (other.kind, other.form, other.depth, other.gold)


_QUESTION = re.compile(rb'\{"id":(?!.*?"base":)')
"""How a file of questions begins. That of a task file, which begins alike, says next whose world it is."""


def open_questions(path: Path) -> tuple[str, TaskSet[_AskedQuestion]] | None:
    """The questions of a file; None if it is one of something else.

    Raises:
        InputError: it begins with a question, and cannot be read.
    """
    with path.open("rb") as file:
        if not _QUESTION.match(file.readline()):
            return None
    questions, sha256 = read_questions(path)
    guesses = guesses_of(questions)
    asked = {each.id: _AskedQuestion(each, guesses[each.id]) for each in questions}
    return f"{questions[0].domain}-{path.stem}", TaskSet(asked, asked.__getitem__, sha256)


def _pose(world: AbilityWorld, asked: _AskedQuestion) -> QuestionAndAnswer:
    return asked.question.prompt, gold_text(asked.question)


def _features(asked: _AskedQuestion) -> TaskFeatures:
    """Questions about one task are alike and count together."""
    return TaskFeatures(asked.question.task, None, 0)


_KINDS = tuple(MetricColumn(kind.value, "Right, by kind", label_of(kind.value)) for kind in Kind)
_FORMS = tuple(MetricColumn(f"form.{form.value}", "By form", label_of(form.value)) for form in Form)
_CHANCE = tuple(MetricColumn(f"chance.{way}", "Without knowing the world", label_of(way)) for way in WAYS)

WORLD_MODEL = AbilityDeclaration(
    ability=Ability("world_model"),
    interaction=Interaction(
        lambda world: _QuestionScorer,
        _pose,
        open_file=open_questions,
        features=_features,
        task_command="eai export questions",
    ),
    title="World-model questions",
    short_title="questions",
    verdict=_QuestionVerdict,
    contributions=contributions,
    outcome=outcome,
    columns=(
        MetricColumn("right", "All", "Right"),
        *_KINDS,
        *_FORMS,
        MetricColumn("f1", "Open form", "F1"),
        MetricColumn("parsing", "Grammar errors", "Unreadable", False),
        *_CHANCE,
    ),
    terminal_metrics=(
        "right",
        *(column.metric for column in (*_KINDS, *_FORMS)),
        "f1",
        "parsing",
        f"chance.{GUESS}",
    ),
    overview_headings={"right": "Right", **{kind.value: label_of(kind.value) for kind in Kind}},
    averaged_metrics=(),
    yes_no_metrics=frozenset({"right", *(kind.value for kind in Kind)}),
    is_same_task=alike,
)
