"""Episodes on the two data sets: answers run as in `execute_plan`, and gold plans slip as computed.

The probability is exact. A plan of L steps, each slipping independently with probability p, runs through with
probability q = (1 - p)^L. With up to k new attempts from the start, the probability is 1 - (1 - q)^(k + 1).
If the world and the plan continue, it is the probability that a negative binomial variable (the number of
slips before L successes) is at most k.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.episode import Episode, Slip, SlipSampler
from eai.world.execution import execute_plan
from eai.world.state import State
from made_answers import made_answers
from oracle import MODELS, Oracle
from protocols import EACH_PROTOCOL
from suites import answer_book
from sweeps import sweep

ANSWER_FILES = {
    "virtualhome": ("tasks", "id", "llm_output", (*MODELS, "perturbed.eai-1.0.5", "perturbed2.eai-1.0.5")),
    "behavior": ("records", "identifier", "response", (*MODELS, "gt", "perturb")),
}
"""Position of answers in a benchmark's files: the list, the id and the text of a row; the files."""

REPLANS = (0, 1, 3)
PROBABILITIES = (0.0, 0.05, 0.1, 0.2, 0.3)
SEEDS = {"virtualhome": 2, "behavior": 6}


class ExecutablePlan(NamedTuple):
    """A plan with its task and initial state."""

    task_id: str
    domain: Domain
    initial: State
    actions: tuple[Action, ...]


def read_plan(scorer: ActionSequencingScorer, text: str) -> ExecutablePlan | None:
    """Return the plan of an answer, or None if it cannot be executed."""
    written = scorer.notation.read(text)
    actions = None if isinstance(written, Unreadable) else scorer.resolve_names(written)
    if actions is None or isinstance(actions, ErrorReport):
        return None
    return ExecutablePlan(scorer.task.id, scorer.domain, scorer.task.initial, actions)


def compare_with_execution(
    name: str, protocol: Protocol, store: DataPackStore, answers: Sequence[tuple[str, str]]
) -> dict[str, bool]:
    """Return by task whether an episode of its plan equals the result of `execute_plan`."""
    suite = open_suite(name, Ability.ACTION_SEQUENCING, protocol, source=Source(store))
    suite = suite.choose_suite_for_answers([text for _, text in answers])
    equal = {}
    for task_id, text in answers:
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, ActionSequencingScorer)
        plan = read_plan(scorer, text)
        if plan is not None:
            episode = Episode(plan.domain, plan.initial)
            ended = episode.run(plan.actions)
            executed = execute_plan(plan.domain, plan.initial, plan.actions)
            equal[task_id] = (episode.trajectory, ended) == (executed, executed.failure)
    return equal


@EACH_PROTOCOL
@pytest.mark.parametrize("name", ANSWER_FILES)
def test_an_episode_of_an_answer_equals_its_execution(
    name: str, protocol: Protocol, data_store: DataPackStore
) -> None:
    answers = made_answers(name, Ability.ACTION_SEQUENCING, data_store)
    equal = compare_with_execution(name, protocol, data_store, answers)
    assert [task_id for task_id, is_equal in equal.items() if not is_equal] == []
    assert len(equal) >= len(answers) // 2


@sweep
@EACH_PROTOCOL
@pytest.mark.parametrize("name", ANSWER_FILES)
def test_an_episode_of_a_published_answer_equals_its_execution(
    name: str, protocol: Protocol, data_store: DataPackStore, oracle: Oracle
) -> None:
    rows, task_id, text, files = ANSWER_FILES[name]
    ran = 0
    for file in files:
        held = oracle(name, "action_sequencing", file)[rows]
        answers = [(row[task_id].partition("@")[0], row[text]) for row in held]
        equal = compare_with_execution(name, protocol, data_store, answers)
        assert [differing for differing, is_equal in equal.items() if not is_equal] == [], file
        ran += len(equal)
    assert ran > 700


def find_gold_plans(name: str, store: DataPackStore) -> list[ExecutablePlan]:
    """Return the successful plans of the data set, without additional steps."""
    suite = open_suite(name, Ability.ACTION_SEQUENCING, source=Source(store))
    book = answer_book(name, Ability.ACTION_SEQUENCING, store)
    plans = []
    for task_id in suite.task_ids:
        text = book[task_id].text
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, ActionSequencingScorer)
        plan = read_plan(scorer, text)
        if plan is not None and getattr(scorer.score(text), "success", False):
            executed = execute_plan(plan.domain, plan.initial, plan.actions).executed_actions
            plans.append(plan._replace(actions=executed))
    return plans


def count_attempts(plan: ExecutablePlan, luck: SlipSampler, *, goes_on: bool) -> int | None:
    """Return the number of failed attempts before success, or None if all four attempts fail."""
    episode, rest = Episode(plan.domain, plan.initial, luck), plan.actions
    for attempt in range(max(REPLANS) + 1):
        if episode.run(rest) is None:
            return attempt
        if goes_on:
            rest = plan.actions[len(episode.trajectory.executed_actions) :]
        else:
            episode = Episode(plan.domain, plan.initial, luck)
    return None


def compute_probability(length: int, p: float, replans: int, *, goes_on: bool) -> float:
    """Return the probability that a plan succeeds with this many replans."""
    if goes_on:
        slips = range(replans + 1)
        return math.fsum(math.comb(length - 1 + j, j) * p**j * (1 - p) ** length for j in slips)
    return 1 - (1 - (1 - p) ** length) ** (replans + 1)


def measure_deviations(
    plans: Sequence[ExecutablePlan], seeds: int
) -> Iterator[tuple[tuple[float, bool, int], float]]:
    """Yield the difference from the computed probability, in standard deviations, for each setting."""
    for p, goes_on in product(PROBABILITIES, (False, True)):
        needed = [
            (
                len(plan.actions),
                count_attempts(plan, SlipSampler(p, plan.task_id, seed=seed), goes_on=goes_on),
            )
            for plan, seed in product(plans, range(seeds))
        ]
        for replans in REPLANS:
            chances = [compute_probability(length, p, replans, goes_on=goes_on) for length, _ in needed]
            succeeded = sum([attempt is not None and attempt <= replans for _, attempt in needed])
            deviation = math.sqrt(math.fsum(chance * (1 - chance) for chance in chances))
            difference = succeeded - math.fsum(chances)
            certain = math.inf if difference else 0.0
            yield (p, goes_on, replans), difference / deviation if deviation else certain


@pytest.mark.parametrize("name", SEEDS)
def test_gold_plans_succeed_with_the_computed_probability(name: str, data_store: DataPackStore) -> None:
    measured = dict(measure_deviations(find_gold_plans(name, data_store), SEEDS[name]))
    assert len(measured) == 30
    assert {cell: z for cell, z in measured.items() if abs(z) >= 4} == {}


@pytest.mark.parametrize("name", SEEDS)
def test_nothing_is_executed_if_every_step_slips(name: str, data_store: DataPackStore) -> None:
    for plan in find_gold_plans(name, data_store):
        episode = Episode(plan.domain, plan.initial, SlipSampler(1, plan.task_id))
        assert episode.run(plan.actions) == (Slip() if plan.actions else None)
        assert episode.trajectory.states == (plan.initial,)
