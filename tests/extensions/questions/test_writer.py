from __future__ import annotations

import re
from collections import Counter
from inspect import signature
from pathlib import Path

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.command import questions as command
from eai.extensions.questions.question import QuestionForm, QuestionKind, questions_to_bytes
from eai.extensions.questions.shortcuts import compute_answer_entropy
from eai.extensions.questions.writer import QuestionGenerator
from eai.tasks.prompts.template import PromptTemplates, list_template_names
from eai.tasks.source import Source
from sweeps import swept

CELLS = [(kind, form) for kind in QuestionKind for form in QuestionForm]


def test_equal_arguments_give_equal_bytes_and_other_seeds_other_questions(lamps: Benchmark) -> None:
    first, again, other = (
        questions_to_bytes(QuestionGenerator(lamps).write_questions(number=72, seed=seed))
        for seed in (3, 3, 4)
    )
    assert first == again
    assert first != other


def test_questions_do_not_depend_on_earlier_calls(lamps: Benchmark) -> None:
    writer = QuestionGenerator(lamps)
    list(writer.write_questions(number=20, seed=1))
    again = questions_to_bytes(writer.write_questions(number=40, seed=3))
    assert again == questions_to_bytes(QuestionGenerator(lamps).write_questions(number=40, seed=3))


def test_any_first_part_is_as_evenly_spread(lamps: Benchmark) -> None:
    questions = list(QuestionGenerator(lamps).write_questions(number=108))
    for number in (36, 72, 108):
        counts = Counter((question.kind, question.form) for question in questions[:number])
        assert max(counts.values()) - min(counts.values()) <= 1
        assert set(counts) == set(CELLS)
    assert len({question.prompt for question in questions}) == len({q.id for q in questions}) == 108


def test_only_the_wanted_kinds_and_forms_are_asked(lamps: Benchmark) -> None:
    questions = list(
        QuestionGenerator(lamps).write_questions(
            (QuestionKind.STATE, QuestionKind.WHY_NOT), (QuestionForm.OPEN,), 9, 0
        )
    )
    assert len(questions) == 9
    assert {(question.kind, question.form) for question in questions} == {
        (QuestionKind.STATE, QuestionForm.OPEN),
        (QuestionKind.WHY_NOT, QuestionForm.OPEN),
    }


def test_a_repeated_kind_or_form_adds_no_questions(lamps: Benchmark) -> None:
    kind, form = QuestionKind.STATE, QuestionForm.OPEN
    writer = QuestionGenerator(lamps)
    assert list(writer.write_questions((kind, kind), (form, form), 4)) == list(
        writer.write_questions((kind,), (form,), 4)
    )


def test_there_are_fewer_questions_if_the_tasks_yield_no_more(lamps: Benchmark) -> None:
    questions = list(
        QuestionGenerator(lamps).write_questions((QuestionKind.WHY_NOT,), (QuestionForm.OPEN,), 100_000)
    )
    assert 10 < len(questions) < 100_000


def test_the_command_asks_for_as_many_as_the_library_where_nobody_says_how_many() -> None:
    numbers = [
        signature(each).parameters[n].default
        for each, n in ((QuestionGenerator.write_questions, "number"), (command, "n"))
    ]
    assert numbers == [500, 500]


def test_a_kind_is_given_up_after_five_failures_in_a_row(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[str] = []
    monkeypatch.setattr(
        QuestionGenerator,
        "_make_drafts",
        lambda self, tasks, cell, number, seed: tried.append(cell.kind) or (),
    )
    assert (
        list(
            QuestionGenerator(lamps).write_questions(
                (QuestionKind.STATE, QuestionKind.FORWARD), (QuestionForm.OPEN,)
            )
        )
        == []
    )
    assert Counter(tried) == {QuestionKind.STATE: 5, QuestionKind.FORWARD: 5}


@pytest.mark.parametrize("domain", ["behavior", *swept("virtualhome")])
def test_answers_are_spread_evenly(domain: str, data_store: DataPackStore) -> None:
    questions = list(
        QuestionGenerator(find_benchmark(domain), Source(data_store)).write_questions(number=12 * len(CELLS))
    )
    assert len(questions) == 12 * len(CELLS)
    uneven = [
        (kind.value, form.value, entropy)
        for kind, form in CELLS
        if (entropy := compute_answer_entropy(questions, kind, form)) is None or entropy < 0.8
    ]
    assert uneven == []


def test_every_kind_and_form_has_words_and_own_ones_take_their_place(
    lamps: Benchmark, tmp_path: Path
) -> None:
    assert {f"questions/{kind.value}.{form.value}.txt" for kind, form in CELLS} <= list_template_names()
    (tmp_path / "questions").mkdir()
    (tmp_path / "questions" / "answer.yes_no.txt").write_text("Ja oder nein?")
    (question,) = QuestionGenerator(lamps, templates=PromptTemplates(tmp_path)).write_questions(
        (QuestionKind.FORWARD,), (QuestionForm.YES_NO,), 1
    )
    assert question.prompt.endswith("Ja oder nein?")


def test_without_the_rules_the_questions_are_the_same(lamps: Benchmark) -> None:
    told = {question.id: question for question in QuestionGenerator(lamps).write_questions(number=108)}
    closed = {
        question.id: question for question in QuestionGenerator(lamps).write_questions(number=93, rules=False)
    }
    assert (len(told), len(closed)) == (108, 93)
    left_out = {(told[each].kind, told[each].form) for each in told.keys() - closed.keys()}
    assert left_out == {
        *((QuestionKind.WHY_NOT, form) for form in QuestionForm),
        (QuestionKind.COUNTERFACTUAL, QuestionForm.OPEN),
        (QuestionKind.VALIDATION, QuestionForm.OPEN),
    }
    for name, question in closed.items():
        assert question.model_copy(update={"prompt": told[name].prompt}) == told[name]
        assert not re.search(r"^ +(requirement|becomes)| means: ", question.prompt, re.MULTILINE)
        rules = re.findall(r"^(\w+\(.*?\))(?=:|$)", told[name].prompt, re.MULTILINE)
        assert all(
            head in question.prompt
            for head in rules
            if head.partition("(")[0] in lamps.domain.operator_arities
        )
    assert list(QuestionGenerator(lamps).write_questions((QuestionKind.WHY_NOT,), rules=False)) == []


PROMPT = """\
A small world has these objects, and no others:
- robot [robot], the agent
- lamp_1 [lamp]
- lamp_2 [lamp]
- ball [ball]
- box [box]

This holds in it now, and of what can be said of objects nothing else does; p(a, {b, c}) stands for p(a, b) \
and p(a, c):
"""


def test_a_prompt_begins_with_the_world(lamps: Benchmark) -> None:
    assert all(
        question.prompt.startswith(PROMPT) for question in QuestionGenerator(lamps).write_questions(number=36)
    )
