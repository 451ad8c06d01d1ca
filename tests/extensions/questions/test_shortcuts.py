"""Shortcuts without knowledge of the world get no more than chance."""

from __future__ import annotations

import random
import re
from collections import Counter
from dataclasses import replace

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import Question, QuestionForm, QuestionKind
from eai.extensions.questions.setting import (
    QuestionWithRightAndWrongTexts,
    find_texts_with_shared_operator,
    make_question_setting,
)
from eai.extensions.questions.shortcuts import (
    SHORTCUTS,
    SurfaceCueCounts,
    YesNoOrChoiceQuestion,
    compute_guess_probabilities,
    compute_success_rates_of_shortcuts,
    draw_question_with_least_shortcut_bias,
    find_best_shortcut,
    make_feature_reader,
)
from eai.extensions.questions.writer import QuestionGenerator
from eai.planning.planner import Planner
from eai.tasks.rules import DomainRulesInPrompts
from eai.tasks.source import Source
from extensions.questions.naive import CHOICE
from sweeps import swept

SHARED = ["GRAB(cup)", "GRAB(pan)", "OPEN(cup)", "WALK(cup)"]
"""The first shares a name with each of the others, and none of these shares more."""


def posed(
    shown: list[str], right: int | None, asked: str = "", holding: tuple[str, ...] = ()
) -> YesNoOrChoiceQuestion:
    return YesNoOrChoiceQuestion(shown, right, make_feature_reader(asked, holding, {}))


@pytest.mark.parametrize(
    ("question", "shortcut", "share"),
    [
        (posed(SHARED, 0), "names", 1),
        (posed(SHARED, 2), "names", 0),
        (posed(["GRAB(cup)", "GRAB(pan)", "OPEN(cup)", "OPEN(pan)"], 2), "names", 0.25),
        (posed(["on(cup)", "on(kettle)", "on(pan)", "on(bottle)"], 3), "longest", 0.5),
        (posed(SHARED, 1, "now a pan is in reach"), "text", 1),
        (posed(SHARED, 2, "now a cup is in reach"), "text", 1 / 3),
        (posed(SHARED, 2), "operator", 0.25),
        (posed(["on(cup)", "in(cup)", "by(cup)", "up(cup)"], 1, "", ("in(cup)",)), "unchanged", 1),
        (posed(["on(cup)"], 0), "names", 0.5),
        (posed(["on(cup)"], None), "operator", 0.5),
    ],
)
def test_a_shortcut_is_scored_on_a_question(
    question: YesNoOrChoiceQuestion, shortcut: str, share: float
) -> None:
    assert SurfaceCueCounts().score_shortcuts_and_update_cue_counts(question)[shortcut] == pytest.approx(
        share
    )


def test_shortcuts_learn_from_earlier_questions() -> None:
    ledger = SurfaceCueCounts()
    for place in range(4):
        ledger.score_shortcuts_and_update_cue_counts(
            posed([f"OPEN({place})", "GRAB(cup)", "WALK(cup)", "SIT(cup)"], 0)
        )
    assert (
        ledger.score_shortcuts_and_update_cue_counts(
            posed(["SIT(pan)", "OPEN(pan)", "GRAB(pan)", "WALK(pan)"], 1)
        )["operator"]
        == 1
    )
    closed = SurfaceCueCounts()
    for _ in range(3):
        closed.score_shortcuts_and_update_cue_counts(posed(["on(cup)"], None, "the cup"))
    hits = closed.score_shortcuts_and_update_cue_counts(posed(["on(pan)"], 0, "the pan"))
    assert (hits["operator"], hits["text"]) == (0, 0)


def test_a_statement_by_no_operator_is_right_as_often_as_a_guess() -> None:
    shown = ["A(1)", "B(1)", "C(1)", "nothing"]
    glance = make_feature_reader("", (), {"nothing": ()})
    ledger = SurfaceCueCounts()
    for right in (0, 1, 2):
        ledger.score_shortcuts_and_update_cue_counts(YesNoOrChoiceQuestion(shown, right, glance))
    learned = ledger.score_shortcuts_and_update_cue_counts(
        YesNoOrChoiceQuestion(["A(1)", "nothing", "nothing", "nothing"], 0, glance)
    )
    assert learned["operator"] == 1, "one in three was right, and by chance one in four"


def test_a_question_that_reduces_bias_has_no_excess() -> None:
    ledger = SurfaceCueCounts()
    assert ledger.compute_shortcut_bias_above_limit_if_added(posed(["on(cup)"], 0)) == 0
    while not ledger.compute_shortcut_bias_above_limit_if_added(posed(["on(cup)"], 0)):
        ledger.score_shortcuts_and_update_cue_counts(posed(["on(cup)"], 0))
    assert ledger.compute_shortcut_bias_above_limit_if_added(posed(["on(cup)"], None)) == 0


def test_the_tolerated_bias_grows_with_every_ten_questions() -> None:
    right, wrong = posed(["on(cup)"], 0), posed(["on(cup)"], None)

    def excess(number: int) -> int:
        """That of one question more of a kind of which there were eight too many among so many."""
        ledger = SurfaceCueCounts()
        for question in [right] * 8 + [right, wrong] * ((number - 8) // 2):
            ledger.score_shortcuts_and_update_cue_counts(question)
        return ledger.compute_shortcut_bias_above_limit_if_added(right)

    assert excess(8) > 0
    assert excess(10) < excess(8)
    assert [excess(8) - excess(number) for number in range(8, 34, 2)] == [
        (number // 10) * (excess(8) - excess(10)) for number in range(8, 34, 2)
    ]


KINDS = (QuestionKind.BACKWARD, QuestionKind.INVERSE, QuestionKind.LANDMARKS)
EACH = 40


@pytest.mark.parametrize("domain", ["behavior", *swept("virtualhome")])
def test_no_shortcut_beats_chance(domain: str, data_store: DataPackStore) -> None:
    forms = QuestionForm.CHOICE, QuestionForm.YES_NO
    writer = QuestionGenerator(find_benchmark(domain), Source(data_store))
    questions = list(writer.write_questions(KINDS, forms, 2 * EACH * len(KINDS), seed=5))
    guesses = compute_guess_probabilities(questions)
    for kind in KINDS:
        for form in forms:
            some = [each for each in questions if (each.kind, each.form) == (kind, form)]
            assert len(some) == EACH
            chances = compute_success_rates_of_shortcuts(some, guesses)
            assert set(chances) == {"guess", *SHORTCUTS}
            assert (chances[find_best_shortcut(chances)].share or 0) <= (
                0.3 if form is QuestionForm.CHOICE else 0.55
            )
    choices = [each for each in questions if each.form is QuestionForm.CHOICE]
    assert sum(map(most_shared, choices)) == pytest.approx(sum(q.shortcuts["names"] for q in choices))


def test_a_step_is_asked_about_where_another_by_its_operator_has_the_other_answer(lamps: Benchmark) -> None:
    operators = {"step 1": "TOUCH", "step 2": "GRAB", "step 3": "GRAB", "step 4": "OPEN"}
    right, wrong = ["step 1", "step 2"], ["step 3", "step 4"]
    world = make_question_setting(
        lamps.tasks(Source())["light"], DomainRulesInPrompts(lamps.domain), Planner(lamps.domain), "0"
    )
    about = {step: [name] for step, name in operators.items()}
    item = QuestionWithRightAndWrongTexts(world.states[0], (), 4, right, wrong, (), labels=about)

    def shown(item: QuestionWithRightAndWrongTexts, turn: int) -> set[str]:
        asked = find_texts_with_shared_operator(item.right, item.wrong, operators.__getitem__)
        item = replace(item, yes_no_texts=asked)
        drawn = [
            draw_question_with_least_shortcut_bias(
                item, world, QuestionForm.YES_NO, "", SurfaceCueCounts(), random.Random(n), turn
            )
            for n in range(20)
        ]
        return {text for each in drawn if each is not None for text in each[1].shown}

    assert [shown(item, turn) for turn in (0, 1)] == [{"step 2"}, {"step 3"}]
    assert shown(replace(item, wrong=["step 4"]), 0) == set()


def test_hardly_an_operator_has_one_answer_alone(data_store: DataPackStore) -> None:
    """Questions leave out steps that touch or look at an object, because no plan needs them."""
    asked: dict[str, list[str]] = {}
    writer = QuestionGenerator(find_benchmark("virtualhome"), Source(data_store))
    for question in writer.write_questions(
        [QuestionKind.JUSTIFICATION], [QuestionForm.YES_NO], 2 * EACH, seed=5
    ):
        (number,) = re.findall(r"left out: step (\d+)\?", question.prompt)
        (operator, *_) = re.findall(rf"^{number}\. ([\w-]+)\(", question.prompt, re.MULTILINE)
        asked.setdefault(operator, []).extend(question.answer)
    assert len([name for name, answers in asked.items() if len({*answers}) == 1]) <= 2, asked


def most_shared(question: Question) -> float:
    """Return the credit for taking the choice that shares most names with the others."""
    found = [set(re.findall(r"[\w.]+", text)) for _, text in CHOICE.findall(question.prompt)]
    counts = Counter(name for names in found for name in names)
    scores = [sum(counts[name] - 1 for name in names) for names in found]
    best = max(scores)
    return (scores["ABCD".index(question.answer[0])] == best) / scores.count(best)
