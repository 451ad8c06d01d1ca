"""Trials on the two data sets: attempts are judged as single answers are, and arms keep to their laws."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import get_args

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.attempt import Attempt
from eai.abilities.attempt_options import AttemptOptions, AttemptStart
from eai.abilities.feedback import QuestionWriter
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.trial import Trial
from eai.base.store import Store
from eai.benchmarks.gold_answers import corrupted_versions, heeding_answer, noisy_answer
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.suite import Suite, open_suite
from eai.benchmarks.virtualhome.plan_notation import ObjectWithId
from eai.results.trials import Trials, begin_trial, open_trials, replay
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source
from made_answers import made_answers
from oracle import MODELS, Oracle
from protocols import EACH_PROTOCOL
from suites import answer_book
from sweeps import sweep

ACTIONS = Ability.ACTION_SEQUENCING
ATTEMPTS = 4
EXPLAINED = AttemptOptions(ATTEMPTS - 1, feedback="explained")
HELD_ANSWERS = {
    "virtualhome": ("tasks", "id", "llm_output"),
    "behavior": ("records", "identifier", "response"),
}
"""Where the files of a benchmark have their answers: the list, the id and the text of a row."""


def suite_of(name: str, store: Store, protocol: Protocol = Protocol.STRICT) -> Suite:
    return open_suite(name, ACTIONS, protocol, source=Source(store))


def trials_of(name: str, store: Store, experiment: AttemptOptions) -> Trials:
    """The trials of all tasks with the published prompts."""
    suite, library = suite_of(name, store), Library("official", None, Source(store))
    prompts = library.open(suite.benchmark, ACTIONS)
    return open_trials(suite, experiment, library.asker(suite.benchmark, ACTIONS, prompts), prompts)


def judged_otherwise(suite: Suite, answers: Iterable[tuple[str, str]]) -> list[str]:
    """Return the ids of tasks whose answer has another verdict in a trial than by itself."""
    differing = []
    for task_id, text in answers:
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, ActionSequencing)
        if Trial(scorer, AttemptOptions()).try_answer(text).verdict != scorer.score(text):
            differing.append(task_id)
    return differing


@EACH_PROTOCOL
@pytest.mark.parametrize("name", HELD_ANSWERS)
def test_an_attempt_is_judged_as_a_single_answer_is(name: str, protocol: Protocol, data_store: Store) -> None:
    answers = made_answers(name, ACTIONS, data_store)
    suite = suite_of(name, data_store, protocol).over([text for _, text in answers])
    assert judged_otherwise(suite, answers) == []


@sweep
@EACH_PROTOCOL
@pytest.mark.parametrize("name", HELD_ANSWERS)
def test_an_attempt_of_a_published_model_is_judged_as_a_single_answer_is(
    name: str, protocol: Protocol, data_store: Store, oracle: Oracle
) -> None:
    rows, task_id, text = HELD_ANSWERS[name]
    for number, file in enumerate(MODELS):
        answers = [
            (row[task_id].partition("@")[0], row[text]) for row in oracle(name, ACTIONS.value, file)[rows]
        ]
        suite = suite_of(name, data_store, protocol).over([text for _, text in answers])
        chosen = answers[number :: len(MODELS)]
        assert judged_otherwise(suite, chosen) == []
        assert len(chosen) >= 11


@pytest.fixture
def protocol() -> Protocol:
    """The protocol `strict`; tests of other protocols have fixtures of these names, too."""
    return Protocol.STRICT


@pytest.fixture
def with_ids() -> Mapping[PromptSet, bool]:
    """Whether objects are read with their ids in answers to prompts of a set."""
    return {"official": True, "eai": True}


@pytest.mark.parametrize("prompts", ["official", "eai"])
def test_how_answers_are_read_is_fixed_by_the_prompts(
    prompts: PromptSet, protocol: Protocol, with_ids: Mapping[PromptSet, bool], data_store: Store
) -> None:
    suite, library = (
        suite_of("virtualhome", data_store, protocol),
        Library(prompts, None, Source(data_store)),
    )
    asked = library.open(suite.benchmark, ACTIONS)
    trials = open_trials(suite, EXPLAINED, library.asker(suite.benchmark, ACTIONS, asked), asked)
    gold = answer_book("virtualhome", ACTIONS, data_store)["27_2"].text
    scorer = trials.suite.scorer("27_2")
    assert isinstance(scorer, ActionSequencing)
    plan = scorer.notation.read(gold)
    assert isinstance(plan, WrittenPlan)
    assert any(isinstance(word, ObjectWithId) for word in plan.steps[0].objects) is with_ids[prompts]
    read_as_asked = suite.over([asked["27_2"].user])
    assert replay(read_as_asked, EXPLAINED, "27_2", [gold])[0] == begin_trial(
        trials.suite, EXPLAINED, "27_2"
    ).try_answer(gold)


def played(trials: Trials, task_id: str, policy: Callable[[Prompt, int], str]) -> Sequence[Attempt]:
    """The attempts of a policy, which is given the question and the number of the attempt."""
    inquiry = trials.start_conversation(task_id)
    while not inquiry.is_over:
        inquiry.add_answer(policy(inquiry.question, len(inquiry.attempts) + 1))
    return inquiry.attempts


@pytest.mark.parametrize(("name", "step"), [("virtualhome", 5), ("behavior", 1)])
def test_what_heeds_feedback_needs_it(name: str, step: int, data_store: Store) -> None:
    """It mends one corrupted part an attempt; with the first question asked again it stays where it was."""
    book, rate, seed = answer_book(name, ACTIONS, data_store), 0.1, "0 1"
    trials = trials_of(name, data_store, EXPLAINED)
    first_again = replace(trials, asker=Unchanging(trials.asker.prompt_of, trials.asker.wording))
    mended, gained = [], 0
    for task_id in trials.suite.task_ids[::step]:
        if trials.suite.scorer(task_id).score_missing_answer().excluded is not None:
            continue

        def heeding(question: Prompt, attempt: int, task_id: str = task_id) -> str:
            asked = question.user
            return heeding_answer(book, task_id, asked, attempt, rate=rate, seed=seed, heed=1.0).text

        attempts = played(trials, task_id, heeding)
        versions = list(
            dict.fromkeys(answer.text for answer in corrupted_versions(book, task_id, rate, seed))
        )
        versions += versions[-1:] * ATTEMPTS
        wins = [bool(getattr(trials.suite.score(task_id, text), "success", False)) for text in versions]
        expected = next((k + 1 for k in range(ATTEMPTS) if wins[k]), ATTEMPTS)
        mended.append((task_id, [attempt.response for attempt in attempts] == versions[:expected]))
        gained += len(attempts) > 1 and bool(attempts[-1].verdict.success)
        again = played(first_again, task_id, heeding)
        assert {attempt.response for attempt in again} == {versions[0]}
        assert len(again) == (1 if wins[0] else ATTEMPTS)
    assert [task_id for task_id, as_expected in mended if not as_expected] == []
    assert gained > 15


class Unchanging(QuestionWriter):
    """Asks the first question again, as the published run did."""

    def question(self, trial: Trial) -> Prompt:
        return self.prompt_of(trial.task.id)


class Resampling:
    """A model that answers anew each time, with known chances.

    Args:
        suite: the tasks.
        store: where the gold answers are.
        rate: how often a part is corrupted.
    """

    def __init__(self, suite: Suite, store: Store, rate: float) -> None:
        self._suite = suite
        self._book = answer_book(suite.domain, ACTIONS, store)
        self._rate = rate
        self._succeeds = cache(self._score)

    def answer(self, task_id: str, seed: str) -> str:
        return noisy_answer(self._book, task_id, self._rate, seed).text

    def chance(self, task_id: str, seeds: int) -> float:
        """The share of so many answers that succeed, none of which is given in a trial."""
        texts = [self.answer(task_id, f"chance {seed}") for seed in range(seeds)]
        return sum([self._succeeds(task_id, text) for text in texts]) / seeds

    def _score(self, task_id: str, text: str) -> bool:
        return bool(getattr(self._suite.score(task_id, text), "success", False))


@pytest.mark.parametrize(("name", "step"), [("virtualhome", 6), ("behavior", 2)])
def test_the_resampling_arm_keeps_to_its_closed_form(name: str, step: int, data_store: Store) -> None:
    """Success within k answers has the chance 1 - (1 - s)^k, if one succeeds with chance s."""
    trials = trials_of(name, data_store, replace(EXPLAINED, feedback="none"))
    model, seeds = Resampling(trials.suite, data_store, 0.1), 2
    succeeded, chances = [0] * ATTEMPTS, []
    for task_id in trials.suite.task_ids[::step]:
        chance = model.chance(task_id, 16)
        for seed in range(seeds):
            chances.append(chance)
            attempts = played(
                trials,
                task_id,
                lambda _, k, t=task_id, s=seed: model.answer(t, f"{s} {k}"),  # type: ignore[misc]
            )
            if attempts[-1].verdict.success:
                for k in range(len(attempts) - 1, ATTEMPTS):
                    succeeded[k] += 1
    assert succeeded == sorted(succeeded)
    for k in range(1, ATTEMPTS + 1):
        expected = math.fsum(1 - (1 - s) ** k for s in chances)
        # chances are known from 16 answers each, whose error adds to that of the trials
        error = [k * (1 - s) ** (k - 1) * math.sqrt(s * (1 - s) / 16) for s in chances]
        variance = [(1 - (1 - s) ** k) * (1 - s) ** k for s in chances]
        deviation = math.sqrt(math.fsum(variance) + seeds * math.fsum(each**2 for each in error))
        assert abs(succeeded[k - 1] - expected) < 4 * deviation, k


@pytest.mark.parametrize("world", get_args(AttemptStart))
def test_the_scorer_holds_the_true_task_whatever_is_asked(world: AttemptStart, data_store: Store) -> None:
    """Questions about another task's goals change no verdict."""
    trials = trials_of("behavior", data_store, replace(EXPLAINED, world=world))
    task_ids = trials.suite.task_ids[:6]
    book = answer_book("behavior", ACTIONS, data_store)
    prompt_of = trials.asker.prompt_of
    wrong = replace(
        trials, asker=replace(trials.asker, prompt_of=lambda i: prompt_of(task_ids[task_ids.index(i) - 1]))
    )
    for task_id in task_ids:
        answers = [noisy_answer(book, task_id, 0.3, str(k)).text for k in range(ATTEMPTS)]

        def given(_: Prompt, attempt: int, answers: Sequence[str] = answers) -> str:
            return answers[attempt - 1]

        verdicts = [[attempt.verdict for attempt in played(each, task_id, given)] for each in (trials, wrong)]
        assert verdicts[0] == verdicts[1]
        assert wrong.start_conversation(task_id).question != trials.start_conversation(task_id).question
