"""How even the gold answers of questions are, and what can be had of them without knowing the world."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.share import Share
from eai.questions.answers import gold_text, grade
from eai.questions.question import Form, Kind, Question
from eai.results.rate import Rate, rate_of

GUESS = "guess"
"""What guessing is called beside the shortcuts."""


@dataclass(frozen=True, slots=True)
class Balance:
    """How even the answers to the questions of one kind and form are.

    Attributes:
        number: how many there are.
        entropy: of their answers, as a share of what it would be if all were equally frequent that could be:
            yes and no, the letters, what can become of a plan, else in open form as many different ones as
            there are. None if there are fewer than two questions.
    """

    number: int
    entropy: float | None


def balance_of(questions: Sequence[Question], kind: Kind, form: Form) -> Balance:
    """How even the answers of a kind and form are."""
    chosen = [question for question in questions if question.kind is kind and question.form is form]
    if len(chosen) < 2:
        return Balance(len(chosen), None)
    counts = Counter(map(_label, chosen))
    shares = [Rate(times, len(chosen)).share or 0.0 for times in counts.values()]
    most = max([question.options for question in chosen]) or len(counts)
    entropy = 0.0 - sum([share * math.log2(share) for share in shares])
    return Balance(len(chosen), Rate(entropy, math.log2(most)).share if most > 1 else 0.0)


def _label(question: Question) -> tuple[str, ...]:
    """The answer; of what becomes of a plan only whether it works, fails at a step or misses a goal."""
    if question.form is Form.OPEN and question.kind in (Kind.COUNTERFACTUAL, Kind.VALIDATION):
        return (question.answer[0].partition(" ")[0],)
    return question.answer


def guesses_of(questions: Sequence[Question]) -> dict[str, float]:
    """How often guessing hits each question, by id: at random; in open form with the most common answer."""
    common = _common_answers(questions)
    return {
        question.id: Rate(1, question.options).share or float(grade(question, common[question.kind]).exact)
        for question in questions
    }


def chances_of(questions: Sequence[Question], guesses: Mapping[str, float]) -> dict[str, Rate]:
    """What guessing gives, and what each shortcut, by name; where there is no shortcut it guesses.

    Args:
        questions: the questions.
        guesses: how often guessing hits each, by id.
    """
    names = dict.fromkeys([GUESS, *(name for question in questions for name in question.shortcuts)])
    return {
        name: rate_of([Share(each.shortcuts.get(name, guesses[each.id]), 1) for each in questions])
        for name in names
    }


def best_chance(chances: Mapping[str, Rate]) -> str:
    """The name of what gives most; guessing, if nothing gives more."""
    return max(chances, key=lambda name: chances[name].numerator)


def _common_answers(questions: Iterable[Question]) -> dict[Kind, str]:
    """The gold answer that most questions in open form of each kind have; of several the first."""
    answers: dict[Kind, Counter[str]] = {kind: Counter() for kind in Kind}
    for question in questions:
        if question.form is Form.OPEN:
            answers[question.kind][gold_text(question)] += 1
    return {kind: max(count, key=count.__getitem__, default="") for kind, count in answers.items()}
