from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import pytest

from by_path import TESTS
from eai.abilities.declaration import get_declaration
from eai.abilities.feedback import REASONS_PREFIX
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import (
    AnswerInParts,
    make_noisy_answer,
    make_noisy_answer_heeding_feedback,
    open_answers_of_planner,
    open_gold_answers,
)
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.planning.search import Limits
from eai.results.summary import compute_metric_rates
from eai.tasks.source import Source
from suites import answer_book, planned_book
from sweeps import every

BOOK = {
    task_id: AnswerInParts(tuple(f"{task_id}{letter}" for letter in "abcdefgh"), " ".join) for task_id in "12"
}
DOMAINS = TESTS / "pddl" / "domains"
SUBGOALS = Ability.SUBGOAL_DECOMPOSITION
PLANS = ("virtualhome", Ability.ACTION_SEQUENCING)


def test_noise_depends_on_its_arguments_alone() -> None:
    assert make_noisy_answer(BOOK, "1", 0.0, "0").text == "1a 1b 1c 1d 1e 1f 1g 1h"
    texts = {make_noisy_answer(BOOK, "1", 0.5, str(seed)).text for seed in range(20)}
    assert len(texts) > 15
    assert make_noisy_answer(BOOK, "1", 0.5, "3") == make_noisy_answer(BOOK, "1", 0.5, "3")


def test_noise_drops_repeats_swaps_and_replaces_parts() -> None:
    answers = [make_noisy_answer(BOOK, "1", 0.3, str(seed)).parts for seed in range(50)]
    gold = BOOK["1"].parts
    assert any(len(parts) < len(gold) for parts in answers)
    assert any(part == after for parts in answers for part, after in pairwise(parts))
    assert any(part > after for parts in answers for part, after in pairwise(parts))
    assert any(part.startswith("2") for parts in answers for part in parts)


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_a_task_without_an_answer_has_no_noisy_answer(rate: float) -> None:
    book = {"1": AnswerInParts((), json.dumps, "no plan exists")}
    answer = make_noisy_answer(book, "1", rate, "0")
    assert (answer.why_none, answer.text) == ("no plan exists", "")


@pytest.mark.parametrize(("heed", "second"), [(1.0, "word"), (0.0, "")])
def test_an_answer_that_lost_its_only_part_is_repaired(heed: float, second: str) -> None:
    book = {"1": AnswerInParts(("word",), "".join)}
    seed = next(seed for seed in map(str, range(99)) if make_noisy_answer(book, "1", 1.0, seed).text == "")

    def answer(question: str, attempt: int) -> str:
        return make_noisy_answer_heeding_feedback(
            book, "1", question, attempt, error_rate=1.0, seed=seed, repair_probability=heed
        ).text

    assert answer("Say it.", 1) == answer("Say it.", 2) == ""
    assert answer(f"Say it.\n\n{REASONS_PREFIX} 1:", 2) == second
    assert answer(f"Say it.\n\n{REASONS_PREFIX} 1:\n\nword\n\n{REASONS_PREFIX} 2:", 3) == "word"


@pytest.mark.parametrize("suite", [PLANS, ("virtualhome", Ability.GOAL_INTERPRETATION)])
def test_gold_answers_are_right(data_store: DataPackStore, suite: tuple[str, Ability]) -> None:
    domain, ability = suite
    book = answer_book(domain, ability, data_store)
    scored = open_suite(domain, ability, Protocol.STRICT, source=Source(data_store))
    verdicts = [scored.score(task_id, book[task_id].text) for task_id in [*book][:40]]
    rate = compute_metric_rates(verdicts, ability)[next(iter(get_declaration(ability).overview_headings))]
    assert rate.percent == 100.0


@pytest.mark.parametrize("name", [path.parent.name for path in sorted(DOMAINS.glob("*/domain.pddl"))])
def test_gold_subgoals_of_pddl_tasks_succeed(name: str) -> None:
    """Their actions use objects that no subgoal names, such as a place or a lever."""
    suite = open_suite(f"pddl:{DOMAINS / name / 'domain.pddl'},{DOMAINS / name}", SUBGOALS)
    book = open_gold_answers(suite.benchmark, SUBGOALS)
    verdicts = {task_id: suite.score(task_id, book[task_id].text) for task_id in suite.task_ids}
    assert [task_id for task_id, verdict in verdicts.items() if not verdict.success] == []
    assert len(verdicts) > 1


def test_the_whole_goal_of_a_pddl_task_is_too_large_for_a_subgoal() -> None:
    """For one subgoal, at most two actions are tried."""
    folder = DOMAINS / "gripper"
    suite = open_suite(f"pddl:{folder / 'domain.pddl'},{folder}", SUBGOALS)
    verdict = suite.score("two-balls", '{"output": ["in(b1, garden) and in(b2, garden)"]}')
    assert isinstance(verdict, SubgoalVerdict)
    assert verdict.category is SubgoalAnswerCategory.RUNTIME


@pytest.mark.parametrize(
    ("goal", "states", "why_none", "text"),
    [
        ("(r a)", 100, "no plan exists", ""),
        ("(p b)", 1, "no plan was found within the limits of the search", ""),
        ("(p a)", 100, "", "[]"),
    ],
)
def test_a_task_without_a_plan_has_no_planned_answer(
    tmp_path: Path, goal: str, states: int, why_none: str, text: str
) -> None:
    (tmp_path / "domain.pddl").write_text(
        "(define (domain two) (:predicates (p ?x) (r ?x)) (:action mk :parameters (?x) :effect (p ?x)))"
    )
    (tmp_path / "p1.pddl").write_text(
        f"(define (problem q) (:domain two) (:objects a b) (:init (p a)) (:goal {goal}))"
    )
    benchmark = find_benchmark(f"pddl:{tmp_path / 'domain.pddl'},{tmp_path}")
    answer = open_answers_of_planner(benchmark, Ability.ACTION_SEQUENCING, limits=Limits(states))["q"]
    assert (answer.why_none, answer.text) == (why_none, text)


@every(8)
def test_the_planner_reaches_all_reachable_goals(data_store: DataPackStore, every: int) -> None:
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING, source=Source(data_store))
    book = planned_book(suite.domain, suite.ability, data_store)
    chosen = suite.task_ids[::every]
    verdicts = {task_id: suite.score(task_id, book[task_id].text) for task_id in chosen}
    failed = [task_id for task_id, v in verdicts.items() if v.excluded is None and not v.success]
    assert failed == []


@pytest.mark.parametrize("ability", [Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION])
def test_planned_answers_succeed_in_behavior(data_store: DataPackStore, ability: Ability) -> None:
    suite = open_suite("behavior", ability, source=Source(data_store))
    book = planned_book("behavior", ability, data_store)
    assert tuple(book) == suite.task_ids
    assert all(suite.score(task_id, book[task_id].text).success for task_id in [*book][3:20:4])


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_gold_answers_have_the_tasks_and_order_of_their_suite(
    data_store: DataPackStore, ability: Ability
) -> None:
    suite = open_suite("behavior", ability, source=Source(data_store))
    book = answer_book("behavior", ability, data_store)
    assert tuple(book) == suite.task_ids == tuple(suite.benchmark.tasks_for(ability, suite.source))


def test_the_planner_has_no_answers_for_transition_modeling() -> None:
    with pytest.raises(InputError, match="eai/planner has no answer to virtualhome transition_modeling"):
        planned_book("virtualhome", Ability.TRANSITION_MODELING)
