"""The gold plans of the two data sets, played as commands."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.reports import action_text
from eai.abilities.verdict import PlanVerdict, Unreadable, compute_goal_gain
from eai.agents.game_setup import GameSetup
from eai.agents.gym import TextEnvironment, make
from eai.agents.reference import make_setup
from eai.agents.rules import STANDARD
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.results.reward import Reward, Shaping
from eai.tasks.short_lists import expand_shortened_lists
from eai.tasks.source import Source
from suites import answer_book
from sweeps import swept

SOLVED = {"virtualhome": 337, "behavior": 100}
"""Number of tasks that the data set's own plans solve, with errata corrected."""

SOLVED_IN_SIGHT = {"virtualhome": 336, "behavior": 100}
"""Number of these tasks whose plans name only objects that have been seen."""

names = pytest.mark.parametrize("name", SOLVED)


@pytest.fixture(scope="module", autouse=True)
def forget_games() -> Iterator[None]:
    """Drop the cached setups of tasks: 3,400 of them take 250 MB."""
    yield
    make_setup.cache_clear()


class Plan(NamedTuple):
    """A gold plan that solves its task, as steps of an answer and as lines."""

    task_id: str
    parts: Sequence[str]
    lines: Sequence[str]


@cache
def gold_plans(name: str, store: DataPackStore) -> tuple[Plan, ...]:
    suite = open_suite(name, Ability.ACTION_SEQUENCING, source=Source(store))
    book = answer_book(name, Ability.ACTION_SEQUENCING, store)
    plans = []
    for task_id in suite.task_ids:
        scorer, answer = suite.scorer(task_id), book[task_id]
        assert isinstance(scorer, ActionSequencingScorer)
        verdict = scorer.score(answer.text)
        assert isinstance(verdict, PlanVerdict)
        written = scorer.notation.read(answer.text)
        if verdict.success and not isinstance(written, Unreadable):
            actions = scorer.resolve_names(written)
            assert isinstance(actions, tuple)
            lines = [action_text(action, scorer.task.scene) for action in actions]
            plans.append(Plan(task_id, answer.parts, lines))
    return tuple(plans)


def play(
    environment: TextEnvironment, task_id: str, commands: Sequence[str]
) -> tuple[list[float], dict[str, Any]]:
    """Return all rewards of a game, and the info of its last turn."""
    _, info = environment.reset(seed=0, options={"task_id": task_id})
    paid = []
    for command in commands:
        _, reward, terminated, _, info = environment.step(command)
        paid.append(float(reward))
        if terminated:
            break
    return paid, info


@names
def test_gold_plans_win(name: str, data_store: DataPackStore) -> None:
    environment = make(name, source=Source(data_store))
    plans = gold_plans(name, data_store)
    assert len(plans) == SOLVED[name]
    for plan in plans:
        for commands in (plan.lines, plan.parts):
            paid, info = play(environment, plan.task_id, commands)
            assert (sum(paid), paid[-1], info["won"]) == (1.0, 1.0, True), plan.task_id


@names
def test_gold_plans_win_in_a_partial_view(name: str, data_store: DataPackStore) -> None:
    environment = make(name, observe="partial", source=Source(data_store))
    plans = gold_plans(name, data_store)
    won = [plan for plan in plans if play(environment, plan.task_id, plan.lines)[1]["won"]]
    assert len(won) == SOLVED_IN_SIGHT[name]


@names
def test_an_opening_of_the_standard_setting_has_at_most_12_000_characters(
    name: str, data_store: DataPackStore
) -> None:
    environment = make(name, source=Source(data_store), rules=STANDARD, budget=None)
    plans = gold_plans(name, data_store)
    openings = [environment.reset(seed=0, options={"task_id": plan.task_id})[0] for plan in plans]
    assert max(map(len, openings)) <= 12_000


@names
@pytest.mark.parametrize("gamma", [1.0, 0.9])
def test_the_return_of_progress_is_the_gain_at_the_end(
    name: str, gamma: float, data_store: DataPackStore
) -> None:
    environment = make(name, reward="progress", gamma=gamma, source=Source(data_store))
    for plan in gold_plans(name, data_store)[::4]:
        _, info = environment.reset(seed=0, options={"task_id": plan.task_id})
        start = info["goals"]
        for commands in (plan.lines, plan.lines[: len(plan.lines) // 2]):
            paid, info = play(environment, plan.task_id, commands)
            returned = math.fsum(gamma**t * reward for t, reward in enumerate(paid))
            gained = compute_goal_gain(info["goals"], start)
            assert gained is not None
            assert returned == pytest.approx(gamma ** len(paid) * gained), plan.task_id


@names
def test_an_episode_has_the_value_of_its_plan(name: str, data_store: DataPackStore) -> None:
    environment = make(name, reward="goals", until="done", source=Source(data_store))
    suite = open_suite(name, Ability.ACTION_SEQUENCING, source=Source(data_store))
    worth = Reward(suite, Shaping.GOALS)
    judged = []
    for plan in gold_plans(name, data_store)[::5]:
        for chosen in (slice(None), slice(-1), slice(1, None)):
            text = environment.benchmark.notation.plans.join(plan.parts[chosen])
            verdict = suite.score(plan.task_id, text)
            assert isinstance(verdict, PlanVerdict)
            carried_out = plan.lines[chosen]
            if not verdict.executable:
                assert verdict.error is not None
                assert verdict.error.step is not None
                carried_out = carried_out[: verdict.error.step + 1]
            paid, info = play(environment, plan.task_id, [*carried_out, "DONE"])
            assert info["goals"] == list(verdict.goals_satisfied)
            assert sum(paid) == worth(plan.task_id, text)
            assert info["won"] or not verdict.success
            judged.append((verdict.executable, verdict.success))
    assert {*judged} == {(True, True), (True, False), (False, False)}


@names
@pytest.mark.parametrize(
    ("reward", "every"),
    [*((each, 1 if each is not Shaping.REPAIR else 40) for each in Shaping), *swept((Shaping.REPAIR, 1))],
)
def test_an_agent_that_ends_at_once_earns_nothing(
    name: str, reward: Shaping, every: int, data_store: DataPackStore
) -> None:
    environment = make(name, reward=reward, gamma=0.9, until="done", source=Source(data_store))
    tasks = [
        task_id for task_id in environment.task_ids if environment._tasks[task_id].unplannable_reason is None
    ]
    assert len(tasks) == SOLVED[name]
    assert {tuple(play(environment, task_id, ["DONE"])[0]) for task_id in tasks[::every]} == {(0.0,)}


def mentioned(text: str, setup: GameSetup) -> set[str]:
    words = {word.strip(".") for word in re.findall(r"[\w.]+", text)}
    return words & {*setup.task.scene.index}


def introduced(text: str, heading: str) -> set[str]:
    """Return the objects that a text introduces under a heading."""
    lines = text.partition(heading)[2].partition("\n\n")[0].splitlines()
    return {line.partition(" [")[0] for line in lines}


@names
def test_no_object_is_mentioned_before_it_is_seen(name: str, data_store: DataPackStore) -> None:
    environment = make(name, observe="partial", admissible=True, source=Source(data_store))
    hidden = 0
    for plan in gold_plans(name, data_store)[::7]:
        told, info = environment.reset(seed=0, options={"task_id": plan.task_id})
        told = expand_shortened_lists(told)
        setup = environment.game.setup
        known = introduced(told, "Objects [kind]: properties\n")
        hidden += not {setup.task.scene.objects[i].name for i in setup.observer.subjects} <= known
        assert mentioned(told.partition("Objects [kind]: properties\n")[2], setup) <= known
        for command in plan.lines:
            assert mentioned(" ".join(info["admissible_commands"]), setup) <= known
            told, _, over, _, info = environment.step(command)
            told = expand_shortened_lists(told)
            known |= introduced(told, "You see for the first time:\n")
            assert mentioned(told, setup) <= known | mentioned(command, setup)
            if over:
                break
    assert hidden
