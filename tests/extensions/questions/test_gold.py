"""Every gold answer is what a naive engine makes of the prompt alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import Question, QuestionForm, QuestionKind
from eai.extensions.questions.writer import QuestionGenerator
from eai.logic.traversal import find_object_names
from eai.tasks.source import Source
from eai.tasks.task import GoalKind
from extensions.questions.naive import answer_of, read_world
from sweeps import swept

CELLS = len(QuestionKind) * len(QuestionForm)


def recomputed(question: Question, benchmark: Benchmark, source: Source) -> frozenset[str]:
    task = benchmark.tasks(source)[question.task]
    names = read_world(question.prompt, benchmark.domain).scene.index.keys()
    goals = [
        goal.formula
        for goal in task.goals
        if goal.kind is not GoalKind.ACTION and set(find_object_names(goal.formula)) <= names
    ]
    return answer_of(question, benchmark.domain, goals)


def differing(benchmark: Benchmark, source: Source, number: int, seed: int = 0) -> list[str]:
    questions = list(QuestionGenerator(benchmark, source).write_questions(number=number, seed=seed))
    assert {question.kind for question in questions} == set(QuestionKind)
    return [
        f"{question.id}: {sorted(question.answer)} is {sorted(naive)}"
        for question in questions
        if frozenset(question.answer) != (naive := recomputed(question, benchmark, source))
    ]


def test_gold_answers_of_the_example_world_are_right(lamps: Benchmark) -> None:
    assert differing(lamps, Source(), 4 * CELLS) == []


DOMAIN = """
(define (domain blocks) (:requirements :strips :typing) (:types block)
 (:predicates (on ?x ?y - block) (ontable ?x - block) (clear ?x - block) (handempty) (holding ?x - block))
 (:action pick-up :parameters (?x - block)
  :precondition (and (clear ?x) (ontable ?x) (handempty))
  :effect (and (not (ontable ?x)) (not (clear ?x)) (not (handempty)) (holding ?x)))
 (:action put-down :parameters (?x - block)
  :precondition (holding ?x)
  :effect (and (not (holding ?x)) (clear ?x) (handempty) (ontable ?x)))
 (:action stack :parameters (?x ?y - block)
  :precondition (and (holding ?x) (clear ?y))
  :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (handempty) (on ?x ?y)))
 (:action unstack :parameters (?x ?y - block)
  :precondition (and (on ?x ?y) (clear ?x) (handempty))
  :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (handempty)) (not (on ?x ?y)))))
"""
PROBLEM = """
(define (problem p1) (:domain blocks) (:objects a b c d - block)
 (:init (ontable a) (on b a) (clear b) (ontable c) (on d c) (clear d) (handempty))
 (:goal (and (on a b) (on b c) (on c d))))
"""


def test_gold_answers_of_pddl_worlds_are_right(tmp_path: Path) -> None:
    (tmp_path / "domain.pddl").write_text(DOMAIN)
    (tmp_path / "p1.pddl").write_text(PROBLEM)
    blocks = find_benchmark(f"pddl:{tmp_path / 'domain.pddl'},{tmp_path / 'p1.pddl'}")
    assert differing(blocks, Source(), 3 * CELLS) == []


@pytest.mark.parametrize("kind", [QuestionKind.FORWARD, QuestionKind.STATE])
def test_facts_that_held_before_do_not_reveal_the_answer(
    kind: QuestionKind, data_store: DataPackStore
) -> None:
    """An answer that nothing has changed is right about half the time."""
    behavior = find_benchmark("behavior")
    right = 0
    for question in QuestionGenerator(behavior, Source(data_store)).write_questions(
        (kind,), (QuestionForm.YES_NO,), 160
    ):
        world = read_world(question.prompt, behavior.domain)
        (statement,) = re.findall(r"Does (.+) hold a", question.prompt)
        held = world.fact(statement) in world.start
        right += question.answer == ("yes" if held else "no",)
    assert 0.35 * 160 < right < 0.65 * 160


@pytest.mark.parametrize("domain", ["virtualhome", *swept("behavior")])
def test_gold_answers_of_households_are_right(domain: str, data_store: DataPackStore) -> None:
    assert differing(find_benchmark(domain), Source(data_store), CELLS, seed=1) == []
