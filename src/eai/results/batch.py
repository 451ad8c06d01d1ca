"""Scores many answers, in this process or in several processes. Missing answers get records, too."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, islice, tee
from operator import length_hint
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Verdict
from eai.benchmarks.suite import Suite
from eai.results.options import ScoringOptions
from eai.results.record import NOT_ANSWERED, Record
from eai.results.records import MAX_BATCH_RECORDS, RecordBatch, RunShard, make_record, make_record_batch
from eai.results.responses import Response, ResponseFile, ResponseRow, read_response
from eai.results.workers import MAX_BATCH_SIZE, MIN_BATCH_SIZE, WorkerPool, split_batches

if TYPE_CHECKING:
    from eai.results.reward import Reward

NO_ROW = "the response file has no row of the task"
"""Reason for a missing answer if the response file has no row for the task."""


OTHER_RULES = "the model played the task by other rules of the game"
"""Reason for a missing answer if the model played the task by rules other than the scored run's.

The task counts as failed.
"""


ProgressCallback: TypeAlias = Callable[[int], None]
"""Function that is called with the number of answers scored so far."""


class Scoring(WorkerPool):
    """Scores streams of answers, in this process or with workers (processes) that live until it is closed.

        with Scoring(workers=8) as scoring:
            for record in scoring.score_records(suite, "my-model", responses):
                ...

    Results come in the order of the answers and are equal for any number of workers. Only a few batches are
    read ahead, so memory does not grow with the stream. If a worker dies, its batches are scored again: no
    answer is lost or scored twice. Workers import the main program, which must therefore start below ``if
    __name__ == "__main__":``.

    Args:
        workers: number of processes; with fewer than two, this process does the work.
    """

    def score_records(
        self, suite: Suite, model: str, responses: Iterable[Response], *, explanations: bool = False
    ) -> Iterator[Record]:
        """Yield the records (verdicts with their answers) of a model's answers, in order.

        Args:
            suite: the tasks, adapted to these answers (`Suite.choose_suite_for_answers`).
            model: name of the model that answered.
            responses: the answers; a task may have any number of answers.
            explanations: put the step-by-step explanation into each record.
        """
        return self._score_responses(suite, model, responses, ScoringOptions(explanations=explanations))

    def _score_responses(
        self, suite: Suite, model: str, responses: Iterable[Response], settings: ScoringOptions
    ) -> Iterator[Record]:
        workers = (
            self if suite.is_openable_by_reference else Scoring()
        )  # workers cannot open a suite that has no name
        answered, to_score = tee(responses)
        batch_sizes = workers._choose_first_and_max_batch_size(suite, length_hint(responses))
        outcomes = workers.map_batches(
            partial(_score_batch, suite, settings), to_score, batch_sizes=batch_sizes
        )
        return map(partial(_make_record, suite, model), answered, outcomes)

    def score_in_batches(
        self,
        suite: Suite,
        answers: ResponseFile,
        unanswered: Mapping[str, str],
        settings: ScoringOptions,
        finish: Callable[[Record], Record] | None = None,
        shard: RunShard | None = None,
        skip: int = 0,
    ) -> Iterator[RecordBatch]:
        """Yield the records (scored answers) of all tasks of a run, ready to be written, a batch at a time.

        Answers come in the order of the data set. If a task may have several answers, they come in the order
        of their file, and tasks without an answer follow. The workers also write the lines of records, so
        that this process only has to store them.

        Args:
            suite: the tasks.
            answers: the answers. Some scoring rules decide from all answers how to read each of them.
            unanswered: mapping from the id of each task without an answer to the reason.
            settings: options of scoring. Its number of processes is ignored: the scorer has its own.
            finish: function that changes a record before it is written; workers get it pickled.
            shard: the part of the tasks to score; None for all tasks.
            skip: number of first records to leave out, because an interrupted command has made them.
        """
        suite = suite.choose_suite_for_answers(response.text for response in answers.responses)
        items = _list_rows_in_task_order(suite, answers, unanswered)
        number = len(answers.responses) + len(unanswered)
        if shard is not None:
            items, number = shard.select_items_of_shard(items), -(-number // shard.of)
        items, number = islice(items, skip, None), number - skip
        mark = partial(
            _add_harness_and_game_rules_of_answer,
            default=_find_harness_and_game_rules_in_answers(suite.ability, answers),
        )
        work = partial(_score_rows_of_response_file, suite, settings, answers.model, mark, finish)
        if not self.has_worker_processes or not suite.is_openable_by_reference:
            sizes = (
                (1, 1)
                if suite.ability is Ability.TRANSITION_MODELING
                else (MIN_BATCH_SIZE, MAX_BATCH_RECORDS)
            )
            return (ready for batch in split_batches(items, 1, *sizes) for ready in work(batch))
        first, largest = self._choose_first_and_max_batch_size(suite, number)
        return self.map_batches(
            work, items, batch_sizes=(min(first, MAX_BATCH_RECORDS), min(largest, MAX_BATCH_RECORDS))
        )

    def compute_rewards(self, reward: Reward, answers: Iterable[tuple[str, str]]) -> Iterator[float | None]:
        """Yield the reward of each answer, in order; None if the task has no reward (`Grade.value`).

        Args:
            reward: the reward function of a suite.
            answers: pairs of a task id and an answer to the task.
        """
        workers = self if reward.suite.is_openable_by_reference else Scoring()
        sizes = workers._choose_first_and_max_batch_size(reward.suite, length_hint(answers))
        return workers.map_batches(partial(_compute_batch_rewards, reward), answers, batch_sizes=sizes)

    def _choose_first_and_max_batch_size(self, suite: Suite, answer_count: int) -> tuple[int, int]:
        """Return two numbers: the size of a worker's first batch, and the maximum size of a batch.

        Both are small if a planner may take minutes for an answer. If the number of answers is known, each
        worker gets two equal batches, because each batch has a fixed cost.

        Args:
            suite: the suite that the answers are for.
            answer_count: number of answers; 0 if unknown.
        """
        if suite.ability is Ability.TRANSITION_MODELING:
            return 1, 4
        if not answer_count:
            return MIN_BATCH_SIZE, MAX_BATCH_SIZE
        share = min(max(MIN_BATCH_SIZE, -(-answer_count // (2 * max(1, self._number)))), MAX_BATCH_SIZE)
        return share, share


_ScoringResult: TypeAlias = tuple[Verdict, TaskFeatures | None, VerdictExplanation | None]
"""Result of scoring an answer: its verdict, the features of its task, and the explanation of the verdict."""


def _score_batch(suite: Suite, settings: ScoringOptions, items: Sequence[Response]) -> list[_ScoringResult]:
    return [_score_response(suite, settings, item) for item in items]


def _score_response(suite: Suite, settings: ScoringOptions, item: Response) -> _ScoringResult:
    explanation = None
    if item.unanswered is not None:
        verdict = suite.score_missing_answer(item.task_id)
        is_elsewhere = item.unanswered == OTHER_RULES
        if (
            settings.allow_missing
            and not is_elsewhere
            and suite.scorer(item.task_id).find_exclusion() is None
        ):
            verdict = get_declaration(suite.ability).verdict(excluded=NOT_ANSWERED)
    else:
        assessment = suite.assess(item.task_id, item.text)
        explanation = assessment.explain() if settings.explanations else None
        verdict = assessment.verdict
        if settings.look_back is not None and assessment.analyze_failure is not None:
            verdict = assessment.analyze_failure(settings.look_back)
    return verdict, suite.features(item.task_id), explanation


def _score_rows_of_response_file(
    suite: Suite,
    settings: ScoringOptions,
    model: str,
    add_harness_and_game_rules: Callable[[Record], Record],
    finish_record: Callable[[Record], Record] | None,
    rows: Sequence[ResponseRow],
) -> list[RecordBatch]:
    items = [read_response(row, suite.benchmark.data.task_id_of) for row in rows]
    records = [
        add_harness_and_game_rules(_make_record(suite, model, item, _score_response(suite, settings, item)))
        for item in items
    ]
    return [make_record_batch(records if finish_record is None else [*map(finish_record, records)])]


def _compute_batch_rewards(reward: Reward, items: Sequence[tuple[str, str]]) -> list[float | None]:
    return [reward(task_id, text) for task_id, text in items]


def map_unanswered_tasks_to_reason(suite: Suite, answers: ResponseFile) -> dict[str, str]:
    """Return the tasks without a row in a response file, each with `NO_ROW` as the reason."""
    answered = answers.answered_task_ids
    return {task_id: NO_ROW for task_id in suite.task_ids if task_id not in answered}


def _list_rows_in_task_order(
    suite: Suite, answers: ResponseFile, unanswered: Mapping[str, str]
) -> Iterator[ResponseRow]:
    """Yield a response, or a missing answer, for each task of a run, in the order of the data set.

    If the file may have several answers to a task, all answers come in the order of the file, and the missing
    answers follow.
    """
    missing = {task_id: Response(task_id, "", unanswered=why) for task_id, why in unanswered.items()}
    if answers.allows_several_answers_per_task:
        return chain(answers.read_rows(), [missing[i] for i in suite.task_ids if i in missing])
    by_id = {response.task_id: response for response in answers.responses} | missing
    return (by_id[task_id] for task_id in suite.task_ids if task_id in by_id)


def split_answers_by_game_rules(ability: Ability, answers: ResponseFile) -> dict[str | None, ResponseFile]:
    """Return the answers of a response file, grouped by the game rules by which the model played.

    Games by the standard rules come first, under the key None. Each group has the answers of all epochs
    (rounds of answers to all tasks). Empty and unreadable answers fail, whatever the rules. They are added to
    the group of the standard rules, or to the largest group if no game had these rules.
    """
    declared = get_declaration(ability)
    if not declared.takes_turns:
        return {None: answers}
    made_by = declared.read_episode_settings
    epochs = (replace(answers, further_epochs=()), *answers.further_epochs)
    agents = (made_by(response.text) for epoch in epochs for response in epoch.responses)
    counts = Counter(agent.rules for agent in agents if agent is not None)
    if len(counts) < 2:
        return dict.fromkeys(counts or (None,), answers)
    usual = None if None in counts else counts.most_common(1)[0][0]

    def read_game_rules_of_episode_or_default(answer_text: str) -> str | None:
        agent = made_by(answer_text)
        return usual if agent is None else agent.rules

    epochs_by_rules = [epoch.group_answers_by_key(read_game_rules_of_episode_or_default) for epoch in epochs]
    files = {}
    for rules in sorted(counts, key=lambda rules: rules or ""):
        first, *further = [by_key[rules] for by_key in epochs_by_rules if rules in by_key]
        files[rules] = replace(first, further_epochs=tuple(further))
    return files


def _find_harness_and_game_rules_in_answers(ability: Ability, answers: ResponseFile) -> Experiment:
    """Return the first harness named in the answers, and the game rules of the first readable answer.

    A harness is the program that lets a model act.
    """
    declared = get_declaration(ability)
    first: Experiment | None = None
    if not declared.takes_turns:
        return Experiment()
    for agent in filter(
        None, (declared.read_episode_settings(response.text) for response in answers.responses)
    ):
        first = first or agent
        if agent.harness is not None:
            return replace(first, harness=agent.harness)
    return first or Experiment()


def _add_harness_and_game_rules_of_answer(record: Record, default: Experiment) -> Record:
    """Return a record with harness (program that let the model act) and game rules of its episode.

    Both are read from the answer. If the answer cannot be read, both come from ``default``. If it names no
    harness, the harness comes from ``default``.
    """
    agent = get_declaration(record.ability).read_episode_settings(record.response) or default
    return record.add_experiment(replace(agent, harness=agent.harness or default.harness))


def score_run(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: ScoringOptions,
) -> list[Record]:
    """Score answers to a suite, and return their records in a list. See `generate_run_records`."""
    return list(generate_run_records(suite, answers, unanswered, settings))


def generate_run_records(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: ScoringOptions,
    on_progress: ProgressCallback | None = None,
) -> Iterator[Record]:
    """Yield the records (scored answers) of all tasks of a run, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers. Some scoring rules decide from all answers how to read each of them.
        unanswered: mapping from the id of each task without an answer to the reason.
        settings: options of scoring.
        on_progress: called after each answer.
    """
    suite = suite.choose_suite_for_answers(response.text for response in answers.responses)
    rows = _list_rows_in_task_order(suite, answers, unanswered)
    items = [read_response(row, suite.benchmark.data.task_id_of) for row in rows]
    first = _find_harness_and_game_rules_in_answers(suite.ability, answers)
    with Scoring(settings.workers) as scoring:
        scored = scoring._score_responses(suite, answers.model, items, settings)
        for done, record in enumerate(scored, 1):
            yield _add_harness_and_game_rules_of_answer(record, first)
            if on_progress is not None:
                on_progress(done)


def _make_record(suite: Suite, model: str, item: Response, judged: _ScoringResult) -> Record:
    verdict, task, explanation = judged
    about = {"explanation": explanation, "task": task, "sample": item.sample, "unanswered": item.unanswered}
    return make_record(suite, model, item.task_id, item.text, verdict, **about)
