"""Answers to questions scored: one result a question, and how right the answers are by kind and depth."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.share import Share, confusion_shares, of_all
from eai.abilities.verdict import Json
from eai.questions.answers import Graded, grade
from eai.questions.question import Form, Kind, Question
from eai.questions.shortcuts import best_chance, chances_of, guesses_of
from eai.results.certainty import Case, Interval, certainty_of_rate
from eai.results.rate import Rate, rate_of

DEPTHS = ((1, 1), (2, 3), (4, 7), (8, 10**6))
"""How many actions questions of a column are about: least and most."""


@dataclass(frozen=True, slots=True)
class Result:
    """A question, the answer to it, or None if there is none, and how right that is."""

    question: Question
    text: str | None
    graded: Graded


@dataclass(frozen=True, slots=True)
class Row:
    """How right the answers to some questions are.

    Attributes:
        exact: those that are right in all that is asked, among all; without an answer a question is not.
        interval: of this rate, 95 %, with the task as its unit, as questions about one task are alike. None
            if there is no question.
        chance: the best rate without knowing the world, by guessing (at random; in open form with the most
            common answer) or by one of the shortcuts.
        chances: the rates of each of these, by name.
        f1: of all parts of answers in open form, in percent; None if there are none.
        unreadable: answers that cannot be read, among all.
    """

    exact: Rate
    interval: Interval | None
    chance: Rate
    chances: Mapping[str, Rate]
    f1: Rate
    unreadable: Rate


@dataclass(frozen=True, slots=True)
class Table:
    """Rows by kind of question, by form, and of all; the rates of each kind by depth."""

    by_kind: Mapping[Kind, Row]
    by_form: Mapping[Form, Row]
    overall: Row
    by_depth: Mapping[Kind, Sequence[Rate]]


def score(questions: Sequence[Question], answers: Mapping[str, str]) -> list[Result]:
    """The result of every question, in order; ``answers`` are texts by id."""
    return [Result(each, answers.get(each.id), grade(each, answers.get(each.id, ""))) for each in questions]


def tabulate(results: Sequence[Result]) -> Table:
    """The rates of one model."""
    guesses = guesses_of([result.question for result in results])
    kinds = {kind: [r for r in results if r.question.kind is kind] for kind in Kind}
    forms = {form: [r for r in results if r.question.form is form] for form in Form}
    return Table(
        {kind: _row(some, guesses) for kind, some in kinds.items() if some},
        {form: _row(some, guesses) for form, some in forms.items() if some},
        _row(results, guesses),
        {
            kind: [_exact([r for r in some if low <= r.question.depth <= high]) for low, high in DEPTHS]
            for kind, some in kinds.items()
            if some
        },
    )


def table_json(table: Table) -> dict[str, Json]:
    """A table as ``summary.json`` has it; rates are in percent."""
    return {
        "overall": _row_json(table.overall),
        "by_kind": {kind.value: _row_json(row) for kind, row in table.by_kind.items()},
        "by_form": {form.value: _row_json(row) for form, row in table.by_form.items()},
        "by_depth": {
            kind.value: {depth_text(depth): rate.to_json() for depth, rate in zip(DEPTHS, rates, strict=True)}
            for kind, rates in table.by_depth.items()
        },
    }


def depth_text(depth: tuple[int, int]) -> str:
    """A range of depths as ``2-3``."""
    low, high = depth
    return str(low) if low == high else f"{low}-{high}" if high < DEPTHS[-1][1] else f"{low}+"


def _row(results: Sequence[Result], guesses: Mapping[str, float]) -> Row:
    cases = [_case(result, of_all(result.graded.exact)) for result in results]
    certainty = certainty_of_rate(cases)
    chances = chances_of([result.question for result in results], guesses)
    open_form = [result for result in results if result.question.form is Form.OPEN]
    return Row(
        exact=_exact(results),
        interval=None if certainty is None else certainty.by_task,
        chance=chances[best_chance(chances)],
        chances=chances,
        f1=rate_of([confusion_shares("", result.graded.counts)[".f1"] for result in open_form]),
        unreadable=rate_of(
            [of_all(result.text is not None and not result.graded.readable) for result in results]
        ),
    )


def _exact(results: Iterable[Result]) -> Rate:
    return rate_of([of_all(result.graded.exact) for result in results])


def _case(result: Result, share: Share) -> Case:
    return Case(result.question.task, result.question.title, share)


def _row_json(row: Row) -> dict[str, Json]:
    return {
        "exact": row.exact.to_json(),
        "interval": None if row.interval is None else list(row.interval),
        "chance": row.chance.percent,
        "chances": {way: rate.percent for way, rate in row.chances.items()},
        "f1": row.f1.to_json(),
        "unreadable": row.unreadable.to_json(),
    }
