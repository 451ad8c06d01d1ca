from __future__ import annotations

import math

import pytest

from eai.abilities.protocol import Ability
from eai.benchmarks.suite import open_suite
from eai.extensions.adaptive.difficulties import (
    choose_most_informative_tasks,
    estimate_ability,
    load_ability_variance_between_task_groups,
    load_task_difficulties,
)
from suites import SUITES

DIFFICULTIES = {str(place): place / 2 - 4 for place in range(17)}
OWN_NAMES = {task: task for task in DIFFICULTIES}
PLANS = (Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)


def test_before_anything_is_asked_an_ability_is_standard_normal() -> None:
    assert estimate_ability({}, DIFFICULTIES) == (0, 1)


@pytest.mark.parametrize("score", [0.0, 1.0])
def test_the_prior_and_one_answer_balance_in_the_ability(score: float) -> None:
    """One answer to a task of difficulty 0: the score's excess over its chance is the prior's pull."""
    found = estimate_ability({"8": score}, DIFFICULTIES)
    chance = 1 / (1 + math.exp(-found.value))
    assert found.value == pytest.approx(score - chance)
    assert found.error == pytest.approx(1 / math.sqrt(1 + chance * (1 - chance)))


def test_more_answers_lower_the_error_and_better_answers_raise_the_ability() -> None:
    scores = {task: float(difficulty < 1) for task, difficulty in DIFFICULTIES.items()}
    half = dict(list(scores.items())[::2])
    assert estimate_ability(scores, DIFFICULTIES).error < estimate_ability(half, DIFFICULTIES).error < 1
    worse = {task: float(difficulty < -1) for task, difficulty in DIFFICULTIES.items()}
    assert estimate_ability(worse, DIFFICULTIES).value < 0 < estimate_ability(scores, DIFFICULTIES).value


def test_a_hundred_right_answers_to_easy_tasks_do_not_run_away() -> None:
    easy = {str(place): -3.5 for place in range(100)}
    assert 0 < estimate_ability(dict.fromkeys(easy, 1.0), easy).value < 3


def test_near_copies_raise_the_error_but_keep_the_ability() -> None:
    """Of one name the variance between names is added as a whole, of n equal names an n-th of it."""
    alike = {str(place): 0.0 for place in range(10)}
    scores = {task: float(int(task) % 2) for task in alike}
    alone = estimate_ability(scores, alike)
    for names in (1, 2, 5, 10):
        found = estimate_ability(scores, alike, {task: str(int(task) % names) for task in alike}, 0.9)
        assert found.value == alone.value
        assert found.error**2 == pytest.approx(alone.error**2 + 0.9 / names)


def test_the_task_of_even_chance_comes_next() -> None:
    assert choose_most_informative_tasks(3, {}, DIFFICULTIES, OWN_NAMES) == ("8", "7", "9")
    right = {"8": 1.0, "9": 1.0, "10": 1.0}
    ability = estimate_ability(right, DIFFICULTIES).value
    (task,) = choose_most_informative_tasks(1, right, DIFFICULTIES, OWN_NAMES)
    nearest = min(set(DIFFICULTIES) - set(right), key=lambda each: abs(DIFFICULTIES[each] - ability))
    assert task == nearest


def test_tasks_of_the_names_asked_least_come_first() -> None:
    copies = {task: "alike" if 6 <= int(task) <= 10 else task for task in DIFFICULTIES}
    assert choose_most_informative_tasks(3, {}, DIFFICULTIES, copies) == ("8", "11", "5")
    assert choose_most_informative_tasks(1, {"8": 0.0}, DIFFICULTIES, copies) == ("5",)


def test_no_task_is_asked_twice() -> None:
    asked = dict.fromkeys(list(DIFFICULTIES)[:15], 1.0)
    assert set(choose_most_informative_tasks(5, asked, DIFFICULTIES, OWN_NAMES)) == {"15", "16"}
    assert choose_most_informative_tasks(5, dict.fromkeys(DIFFICULTIES, 1.0), DIFFICULTIES, OWN_NAMES) == ()


@pytest.mark.parametrize(("domain", "ability"), SUITES)
def test_all_tasks_of_plans_and_subgoals_have_difficulties(domain: str, ability: Ability) -> None:
    known = load_task_difficulties(domain, ability)
    assert bool(known) == (ability in PLANS)
    assert (load_ability_variance_between_task_groups(domain, ability) > 0) == (
        bool(known) and domain == "virtualhome"
    )
    assert set(known) <= set(open_suite(domain, ability).task_ids)
