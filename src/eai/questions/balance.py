"""How even the gold answers of questions are: whoever always says the same should not be right often."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from eai.metrics.rate import Rate
from eai.questions.question import Form, Kind, Question


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
