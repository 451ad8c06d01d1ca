"""Trials on the two data sets: attempts have the verdicts of single answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import get_args

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.attempt import Attempt
from eai.abilities.feedback import MultiAttemptQuestionWriter
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.replanning_options import AttemptStart, ReplanningOptions
from eai.abilities.trial import MultiAttemptTrial
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import (
    make_noisy_answer,
    make_noisy_answer_heeding_feedback,
    yield_corrupted_answer_and_repaired_versions,
)
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite, open_suite
from eai.benchmarks.virtualhome.plan_notation import ObjectWithId
from eai.results.trials import (
    ReplanningConversationFactory,
    begin_trial,
    make_replanning_conversation_factory,
    replay_attempts_at_task,
)
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source
from made_answers import made_answers
from oracle import MODELS, Oracle
from protocols import EACH_PROTOCOL
from suites import answer_book
from sweeps import sweep

ACTIONS = Ability.ACTION_SEQUENCING
ATTEMPTS = 4
EXPLAINED = ReplanningOptions(ATTEMPTS - 1, feedback="explained")
ANSWER_FIELDS = {
    "virtualhome": ("tasks", "id", "llm_output"),
    "behavior": ("records", "identifier", "response"),
}
"""Position of answers in a benchmark's files: the list, the id and the text of a row."""


def open_plan_suite(name: str, store: DataPackStore, protocol: Protocol = Protocol.STRICT) -> Suite:
    return open_suite(name, ACTIONS, protocol, source=Source(store))


def open_published_trials(
    name: str, store: DataPackStore, experiment: ReplanningOptions
) -> ReplanningConversationFactory:
    """Return the trials of all tasks with the published prompts."""
    suite, library = open_plan_suite(name, store), PromptLibrary("official", None, Source(store))
    prompts = library.open(suite.benchmark, ACTIONS)
    return make_replanning_conversation_factory(
        suite, experiment, library.make_question_writer(suite.benchmark, ACTIONS, prompts), prompts
    )


def find_differing_verdicts(suite: Suite, answers: Iterable[tuple[str, str]]) -> list[str]:
    """Return the ids of tasks whose answer has another verdict in a trial than alone."""
    differing = []
    for task_id, text in answers:
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, ActionSequencingScorer)
        if MultiAttemptTrial(scorer, ReplanningOptions()).try_answer(text).verdict != scorer.score(text):
            differing.append(task_id)
    return differing


@EACH_PROTOCOL
@pytest.mark.parametrize("name", ANSWER_FIELDS)
def test_an_attempt_has_the_verdict_of_a_single_answer(
    name: str, protocol: Protocol, data_store: DataPackStore
) -> None:
    answers = made_answers(name, ACTIONS, data_store)
    suite = open_plan_suite(name, data_store, protocol).choose_suite_for_answers(
        [text for _, text in answers]
    )
    assert find_differing_verdicts(suite, answers) == []


@sweep
@EACH_PROTOCOL
@pytest.mark.parametrize("name", ANSWER_FIELDS)
def test_an_attempt_of_a_published_model_has_the_verdict_of_a_single_answer(
    name: str, protocol: Protocol, data_store: DataPackStore, oracle: Oracle
) -> None:
    rows, task_id, text = ANSWER_FIELDS[name]
    for number, file in enumerate(MODELS):
        answers = [
            (row[task_id].partition("@")[0], row[text]) for row in oracle(name, ACTIONS.value, file)[rows]
        ]
        suite = open_plan_suite(name, data_store, protocol).choose_suite_for_answers(
            [text for _, text in answers]
        )
        chosen = answers[number :: len(MODELS)]
        assert find_differing_verdicts(suite, chosen) == []
        assert len(chosen) >= 11


@pytest.fixture
def protocol() -> Protocol:
    """Return the protocol `strict`. Tests of other protocols override this fixture."""
    return Protocol.STRICT


@pytest.fixture
def with_ids() -> Mapping[PromptSet, bool]:
    """Return for each set of prompts whether objects are read with their ids."""
    return {"official": True, "eai": True}


@pytest.mark.parametrize("prompts", ["official", "eai"])
def test_prompts_decide_whether_answers_are_read_with_ids(
    prompts: PromptSet, protocol: Protocol, with_ids: Mapping[PromptSet, bool], data_store: DataPackStore
) -> None:
    suite = open_plan_suite("virtualhome", data_store, protocol)
    library = PromptLibrary(prompts, None, Source(data_store))
    questions = library.open(suite.benchmark, ACTIONS)
    trials = make_replanning_conversation_factory(
        suite, EXPLAINED, library.make_question_writer(suite.benchmark, ACTIONS, questions), questions
    )
    gold = answer_book("virtualhome", ACTIONS, data_store)["27_2"].text
    scorer = trials.suite.scorer("27_2")
    assert isinstance(scorer, ActionSequencingScorer)
    plan = scorer.notation.read(gold)
    assert isinstance(plan, WrittenPlan)
    assert any(isinstance(word, ObjectWithId) for word in plan.steps[0].objects) is with_ids[prompts]
    read_as_asked = suite.choose_suite_for_answers([questions["27_2"].user])
    assert replay_attempts_at_task(read_as_asked, EXPLAINED, "27_2", [gold])[0] == begin_trial(
        trials.suite, EXPLAINED, "27_2"
    ).try_answer(gold)


def run_policy(
    trials: ReplanningConversationFactory, task_id: str, policy: Callable[[Prompt, int], str]
) -> Sequence[Attempt]:
    """Return the attempts of a policy, which gets the question and the number of the attempt."""
    conversation = trials.start_conversation(task_id)
    while not conversation.is_over:
        conversation.add_answer(policy(conversation.question, len(conversation.attempts) + 1))
    return conversation.attempts


@pytest.mark.parametrize(("name", "step"), [("virtualhome", 5), ("behavior", 1)])
def test_a_model_that_follows_feedback_improves_only_with_feedback(
    name: str, step: int, data_store: DataPackStore
) -> None:
    """It repairs one corrupted part an attempt. Without feedback, its answer stays unchanged."""
    book, rate, seed = answer_book(name, ACTIONS, data_store), 0.1, "0 1"
    trials = open_published_trials(name, data_store, EXPLAINED)
    first_again = replace(
        trials,
        question_writer=RepeatingQuestionWriter(
            trials.question_writer.prompt_of, trials.question_writer.wording
        ),
    )
    repaired, gained = [], 0
    for task_id in trials.suite.task_ids[::step]:
        if trials.suite.scorer(task_id).score_missing_answer().excluded is not None:
            continue

        def follow_feedback(question: Prompt, attempt: int, task_id: str = task_id) -> str:
            text = question.user
            return make_noisy_answer_heeding_feedback(
                book, task_id, text, attempt, error_rate=rate, seed=seed, repair_probability=1.0
            ).text

        attempts = run_policy(trials, task_id, follow_feedback)
        versions = list(
            dict.fromkeys(
                answer.text
                for answer in yield_corrupted_answer_and_repaired_versions(book, task_id, rate, seed)
            )
        )
        versions += versions[-1:] * ATTEMPTS
        wins = [bool(getattr(trials.suite.score(task_id, text), "success", False)) for text in versions]
        expected = next((k + 1 for k in range(ATTEMPTS) if wins[k]), ATTEMPTS)
        repaired.append((task_id, [attempt.response for attempt in attempts] == versions[:expected]))
        gained += len(attempts) > 1 and bool(attempts[-1].verdict.success)
        again = run_policy(first_again, task_id, follow_feedback)
        assert {attempt.response for attempt in again} == {versions[0]}
        assert len(again) == (1 if wins[0] else ATTEMPTS)
    assert [task_id for task_id, as_expected in repaired if not as_expected] == []
    assert gained > 15


class RepeatingQuestionWriter(MultiAttemptQuestionWriter):
    """Asks the first question again, as in the published run."""

    def write_question(self, trial: MultiAttemptTrial) -> Prompt:
        return self.prompt_of(trial.task.id)


class ResamplingModel:
    """A model that answers independently each time, with known probabilities.

    Args:
        suite: the tasks.
        store: the store with the gold answers.
        rate: probability that a part is corrupted.
    """

    def __init__(self, suite: Suite, store: DataPackStore, rate: float) -> None:
        self._suite = suite
        self._book = answer_book(suite.domain, ACTIONS, store)
        self._rate = rate
        self._succeeds = cache(self._score)

    def answer(self, task_id: str, seed: str) -> str:
        return make_noisy_answer(self._book, task_id, self._rate, seed).text

    def chance(self, task_id: str, seeds: int) -> float:
        """Return the share of successful answers in a sample that trials do not use."""
        texts = [self.answer(task_id, f"chance {seed}") for seed in range(seeds)]
        return sum([self._succeeds(task_id, text) for text in texts]) / seeds

    def _score(self, task_id: str, text: str) -> bool:
        return bool(getattr(self._suite.score(task_id, text), "success", False))


@pytest.mark.parametrize(("name", "step"), [("virtualhome", 6), ("behavior", 2)])
def test_resampling_succeeds_with_the_computed_probability(
    name: str, step: int, data_store: DataPackStore
) -> None:
    """Success within k answers has probability 1 - (1 - s)^k, if one succeeds with probability s."""
    trials = open_published_trials(name, data_store, replace(EXPLAINED, feedback="none"))
    model, seeds = ResamplingModel(trials.suite, data_store, 0.1), 2
    succeeded, chances = [0] * ATTEMPTS, []
    for task_id in trials.suite.task_ids[::step]:
        chance = model.chance(task_id, 16)
        for seed in range(seeds):
            chances.append(chance)
            attempts = run_policy(
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
        # chances are estimated from 16 answers each, and their error adds to that of the trials
        error = [k * (1 - s) ** (k - 1) * math.sqrt(s * (1 - s) / 16) for s in chances]
        variance = [(1 - (1 - s) ** k) * (1 - s) ** k for s in chances]
        deviation = math.sqrt(math.fsum(variance) + seeds * math.fsum(value**2 for value in error))
        assert abs(succeeded[k - 1] - expected) < 4 * deviation, k


@pytest.mark.parametrize("world", get_args(AttemptStart))
def test_questions_about_other_goals_do_not_change_verdicts(
    world: AttemptStart, data_store: DataPackStore
) -> None:
    trials = open_published_trials("behavior", data_store, replace(EXPLAINED, world=world))
    task_ids = trials.suite.task_ids[:6]
    book = answer_book("behavior", ACTIONS, data_store)
    prompt_of = trials.question_writer.prompt_of
    wrong = replace(
        trials,
        question_writer=replace(
            trials.question_writer, prompt_of=lambda i: prompt_of(task_ids[task_ids.index(i) - 1])
        ),
    )
    for task_id in task_ids:
        answers = [make_noisy_answer(book, task_id, 0.3, str(k)).text for k in range(ATTEMPTS)]

        def given(_: Prompt, attempt: int, answers: Sequence[str] = answers) -> str:
            return answers[attempt - 1]

        verdicts = [
            [attempt.verdict for attempt in run_policy(variant, task_id, given)]
            for variant in (trials, wrong)
        ]
        assert verdicts[0] == verdicts[1]
        assert wrong.start_conversation(task_id).question != trials.start_conversation(task_id).question
