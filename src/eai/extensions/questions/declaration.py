"""The ability `world_model`: it scores answers to the questions of a file instead of answers to tasks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

from eai.abilities.declaration import (
    AbilityDeclaration,
    AnswerOutcome,
    DomainAndNotation,
    MetricColumn,
    QuestionAndAnswer,
    SingleQuestionInteraction,
    classify_answer_by_counts,
    find_error_outcome,
    get_display_name,
)
from eai.abilities.explanation import VerdictExplanation, write_repair_notes
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import (
    EMPTY_SHARE,
    ConfusionCounts,
    ErrorReport,
    Verdict,
    make_confusion_shares,
    make_rate_contribution_of_answer,
)
from eai.extensions.questions.question import (
    Question,
    QuestionForm,
    QuestionKind,
    format_gold_answer,
    grade_answer,
    read_questions_and_sha256,
)
from eai.extensions.questions.shortcuts import GUESS, SHORTCUTS, compute_guess_probabilities
from eai.tasks.share import Share
from eai.tasks.source import TaskSet
from eai.world.fault import FaultKind

MIN_DEPTHS = {"1": 1, "2-3": 2, "4-7": 4, "8+": 8}
"""Minimum depth (number of actions to consider) of each range of depths, by the range's column heading."""

GUESS_AND_SHORTCUTS = (GUESS, *SHORTCUTS)
"""Names of ways to answer without knowledge of the world: to guess at random, and to use a shortcut rule."""


class _QuestionWithGuessProbability(NamedTuple):
    """A question of a file, and the probability that a guess answers it correctly.

    A guess takes one of the choices at random. Without choices (in open form), it takes the most frequent
    gold answer of the question's kind in the file.
    """

    question: Question
    guess_probability: float


_NO_COUNTS = ConfusionCounts(0, 0, 0)


@dataclass(frozen=True, slots=True)
class _VerdictOnQuestionAnswer(Verdict):
    """The verdict on an answer to a question, with the question's fields that comparisons and tables need.

    Attributes:
        success: whether the answer is completely right. A missing answer is not.
        counts: numbers of right, wrong and missing items of the answer. If one of the gold answers is
            enough, at most one item counts as missing.
        kind: the subject of the question.
        form: the form of the answer.
        depth: number of actions that the answer has to consider.
        gold: the gold answers.
        chances: probability that guessing, or each shortcut, answers the question correctly, by name.
    """

    success: bool = False
    counts: ConfusionCounts = _NO_COUNTS
    kind: QuestionKind | None = None
    form: QuestionForm | None = None
    depth: int = 0
    gold: tuple[str, ...] = ()
    chances: Mapping[str, float] = field(default_factory=dict)


class _QuestionScorer(Scorer):
    """Scores the answers to one question."""

    def __init__(self, asked: _QuestionWithGuessProbability) -> None:
        self._question, self._guess = asked

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer. An unreadable answer is wrong."""
        question, graded = self._question, grade_answer(self._question, text)
        error = ErrorReport(FaultKind.PARSING, None, f"there is no answer of the form {question.form.value}")
        verdict = _VerdictOnQuestionAnswer(
            error=None if graded.readable else error,
            repairs=graded.repairs,
            success=graded.exact,
            counts=graded.counts,
            kind=question.kind,
            form=question.form,
            depth=question.depth,
            gold=question.answer,
            chances={
                shortcut: question.shortcuts.get(shortcut, self._guess) for shortcut in GUESS_AND_SHORTCUTS
            },
        )
        return Assessment(verdict, partial(_make_explanation, question, graded.repairs))


def _make_explanation(question: Question, repairs: Sequence[str]) -> VerdictExplanation:
    wanted = f"right is {question.accept} of {', '.join(question.answer)}"
    return VerdictExplanation(notes=(wanted, *write_repair_notes(repairs)))


def compute_rate_contributions(verdict: _VerdictOnQuestionAnswer) -> dict[str, Share]:
    """Return the numerator and denominator that one answer adds to each rate, by the name of the rate.

    ``right``: whether the answer is right. This also counts for the rates of the question's kind, of its
    form, and of its kind and depth together. Depth is the number of actions to consider. ``chance``: the
    probability that guessing, or a shortcut rule such as "take the longest choice", is right. ``f1``: the F1
    score of the listed items, for open form only. ``parsing``: whether the answer could not be read.
    """
    right = make_rate_contribution_of_answer(verdict.success)
    is_open = verdict.form is QuestionForm.OPEN
    depth = next((name for name, least in reversed(MIN_DEPTHS.items()) if least <= verdict.depth), "")
    return {
        "right": right,
        **{kind.value: right if kind is verdict.kind else EMPTY_SHARE for kind in QuestionKind},
        **{f"form.{form.value}": right if form is verdict.form else EMPTY_SHARE for form in QuestionForm},
        "f1": make_confusion_shares("", verdict.counts)[".f1"] if is_open else EMPTY_SHARE,
        "parsing": make_rate_contribution_of_answer(verdict.error is not None),
        **{
            f"chance.{shortcut}": Share(verdict.chances.get(shortcut, 0.0), 1)
            for shortcut in GUESS_AND_SHORTCUTS
        },
        **{
            f"{kind.value}.depth.{name}": right if (kind, name) == (verdict.kind, depth) else EMPTY_SHARE
            for kind in QuestionKind
            for name in MIN_DEPTHS
        },
        **{
            f"{kind.value}.chance.{shortcut}": Share(verdict.chances[shortcut], 1)
            if kind is verdict.kind
            else EMPTY_SHARE
            for kind in QuestionKind
            for shortcut in GUESS_AND_SHORTCUTS
        },
    }


def find_outcome(verdict: _VerdictOnQuestionAnswer) -> AnswerOutcome:
    """Return the outcome of an answer: success, or the class of its error."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return find_error_outcome(verdict) or classify_answer_by_counts(verdict.counts, can_be_success=False)


def is_same_question(one: _VerdictOnQuestionAnswer, other: _VerdictOnQuestionAnswer) -> bool:
    """Whether two verdicts judge answers to one question.

    A prompt with the rules of actions and a prompt without them ask one question.
    """
    return (one.kind, one.form, one.depth, one.gold) == (other.kind, other.form, other.depth, other.gold)


_QUESTION_FILE_START = re.compile(rb'\{"id":(?!.*?"base":)')
"""Regular expression for the first line of a question file.

The line begins with the key `id`, and has no key `base`. Lines of task files have both keys.
"""


def open_question_file_as_named_task_set(
    path: Path,
) -> tuple[str, TaskSet[_QuestionWithGuessProbability]] | None:
    """Return the name of a set of questions and its questions, or None if the file is not a question file.

    Raises:
        InputError: the file begins with a question but cannot be read.
    """
    with path.open("rb") as file:
        if not _QUESTION_FILE_START.match(file.readline()):
            return None
    questions, sha256 = read_questions_and_sha256(path)
    guesses = compute_guess_probabilities(questions)
    by_id = {
        question.id: _QuestionWithGuessProbability(question, guesses[question.id]) for question in questions
    }
    return f"{questions[0].domain}-{path.stem}", TaskSet(by_id, by_id.__getitem__, sha256)


def _get_prompt_and_answer(
    parts: DomainAndNotation, asked: _QuestionWithGuessProbability
) -> QuestionAndAnswer:
    return asked.question.prompt, format_gold_answer(asked.question)


def _get_features(asked: _QuestionWithGuessProbability) -> TaskFeatures:
    """Return the features of a question for analyses, with the question's task as name.

    Analyses treat questions with one name as dependent on each other.
    """
    return TaskFeatures(asked.question.task, None, 0)


_KIND_COLUMNS = tuple(
    MetricColumn(kind.value, "Right, by kind", get_display_name(kind.value)) for kind in QuestionKind
)
_FORM_COLUMNS = tuple(
    MetricColumn(f"form.{form.value}", "By form", get_display_name(form.value)) for form in QuestionForm
)
_CHANCE_COLUMNS = tuple(
    MetricColumn(f"chance.{way}", "Without knowing the world", get_display_name(way))
    for way in GUESS_AND_SHORTCUTS
)

WORLD_MODEL = AbilityDeclaration(
    ability=Ability("world_model"),
    interaction=SingleQuestionInteraction(
        lambda parts: _QuestionScorer,
        _get_prompt_and_answer,
        open_file=open_question_file_as_named_task_set,
        features=_get_features,
        task_command="eai export questions",
    ),
    title="World-model questions",
    short_title="questions",
    verdict=_VerdictOnQuestionAnswer,
    contributions=compute_rate_contributions,
    outcome=find_outcome,
    columns=(
        MetricColumn("right", "All", "Right"),
        *_KIND_COLUMNS,
        *_FORM_COLUMNS,
        MetricColumn("f1", "Open form", "F1"),
        MetricColumn("parsing", "Grammar errors", "Unreadable", False),
        *_CHANCE_COLUMNS,
    ),
    terminal_metrics=(
        "right",
        *(column.metric for column in (*_KIND_COLUMNS, *_FORM_COLUMNS)),
        "f1",
        "parsing",
        f"chance.{GUESS}",
    ),
    overview_headings={
        "right": "Right",
        **{kind.value: get_display_name(kind.value) for kind in QuestionKind},
    },
    averaged_metrics=(),
    yes_no_metrics=frozenset({"right", *(kind.value for kind in QuestionKind)}),
    is_same_task=is_same_question,
)
