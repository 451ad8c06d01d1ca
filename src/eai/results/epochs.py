"""Makes records (scored answers): of each epoch, if there are several, and of all epochs together.

An epoch is one round of answers to all tasks. The ability declares whether a task counts by the mean over its
epochs or by the majority. The majority is self-consistency: of several answers to a task, the first answer
with the most frequent meaning counts.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeVar

from eai.abilities.answer_text import ANY_VALUE, JsonObject, ParsedAnswer, read_json
from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.declaration import SingleQuestionInteraction, get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.feedback import ScenePerception
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.unread_cause import mark_as_cut_off
from eai.abilities.verdict import Verdict
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite
from eai.results.batch import ProgressCallback, generate_run_records, score_run
from eai.results.certainty import TaskRateContributions
from eai.results.codec import dataclass_to_json, hash_text
from eai.results.cost import group_costs_and_successes_by_cost_unit, make_json_of_cost_per_success
from eai.results.options import ScoringOptions
from eai.results.record import AnswerOrigin, Record
from eai.results.records import (
    MAX_BATCH_RECORDS,
    RECORDS,
    RecordBatch,
    RunDetailsAndRatesByAttempt,
    make_record_batch,
    read_records,
    write_record_batches,
)
from eai.results.repeats import find_success_metric, map_pass_at_k_metrics_to_contributions, pass_at_k_to_json
from eai.results.responses import Response, ResponseFile, format_attempt_name, write_responses
from eai.results.summary import compute_rates_by_attempt, make_contributions_by_metric
from eai.results.totals import RunTotals
from eai.results.trials import Answer, ReplanningConversationFactory, TaskIdAndEpoch, make_trial_record
from eai.tasks.prompts.prompt import BelievedTask, Prompt
from eai.tasks.task import Task

T = TypeVar("T")


def find_majority_index(answers: Sequence[str | None], ability: Ability) -> int:
    """Return the index of the first answer with the most frequent meaning.

    If several meanings are equally frequent, the first of these meanings counts. All answers that are missing
    (None) or cannot be read have one meaning: a failed attempt. `normalise_answer` gives the meaning of an
    answer.
    """
    meanings = [None if text is None else normalise_answer(text, ability) for text in answers]
    return meanings.index(Counter(meanings).most_common(1)[0][0])


def normalise_answer(text: str, ability: Ability) -> str | None:
    """Return an answer without irrelevant differences: answers with equal meanings become equal texts.

    The result is None if the answer cannot be read. The ability declares which differences are irrelevant
    (`SingleQuestionInteraction`).
    """
    interaction = get_declaration(ability).interaction
    reading = read_json(text, ANY_VALUE)
    if isinstance(reading, ParsedAnswer):
        return _convert_json_to_normalised_text(reading.value, interaction)
    start = -1 if interaction.plain_text_prefix is None else text.find(interaction.plain_text_prefix)
    return _normalise_spaces(text[start:]) if start >= 0 else None


def _convert_json_to_normalised_text(value: object, answer_format: SingleQuestionInteraction) -> str:
    if isinstance(value, JsonObject):
        members = [
            f"{json.dumps(key)}:{_convert_json_to_normalised_text(item, answer_format)}"
            for key, item in value.members
        ]
        return "{" + ",".join(members if answer_format.keys_in_order else sorted(members)) + "}"
    if isinstance(value, list):
        elements = [_convert_json_to_normalised_text(item, answer_format) for item in value]
        is_goal = all(isinstance(item, str) for item in value)  # a goal, such as ["inside", "rag", "bucket"]
        is_set = answer_format.lists_are_sets and not is_goal
        return "[" + ",".join(sorted(elements) if is_set else elements) + "]"
    return json.dumps(_normalise_spaces(value) if isinstance(value, str) else value)


def _normalise_spaces(text: str) -> str:
    return " ".join(text.split())


STATED = "stated"
"""Key in the metadata of a question, whose value is the earlier answer that stated its goals."""


SUBGOALS = "subgoals"
"""Key in a question's metadata: a model's earlier answer, whose subgoals the question states."""


@dataclass(frozen=True, slots=True)
class GoalsAndScenesStatedInPrompts:
    """Beliefs: goals or scenes that questions state instead of the goals and scenes of their tasks.

    The goals come from an earlier answer of a model. The scenes were perceived by a model, or by a simulation
    with errors, or they are true scenes in another format, such as pictures.

    Attributes:
        beliefs: mapping from each task to the belief that its question states.
        experiment: the options of a run with these questions, as records store them.
        missing_reason: reason why tasks without a belief have no question.
        metadata: mapping from each task to metadata of its question, such as the earlier answer. They are not
            part of the question, but built-in models read them.
        summaries: for each task, values about its belief, such as its number of errors, by the name of the
            study (variation of questions) that computed them. Records store these values.
        perceive_changed_scene: function that simulates how a changed scene is perceived; None if questions
            describe the scene without errors.
    """

    beliefs: Mapping[str, BelievedTask]
    experiment: Experiment
    missing_reason: str
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    summaries: Mapping[str, Mapping[str, Mapping[str, Any]]] = field(default_factory=dict)
    perceive_changed_scene: ScenePerception | None = None

    def combine_own_scenes_with_goals_of(
        self, source_of_goals: GoalsAndScenesStatedInPrompts
    ) -> GoalsAndScenesStatedInPrompts:
        """Return beliefs with the scenes of this object and the goals of ``source_of_goals``.

        Tasks that one of the two objects lacks are left out.

        Raises:
            InputError: this object and ``source_of_goals`` have different values of one option of the run.
        """
        shared = [task_id for task_id in source_of_goals.beliefs if task_id in self.beliefs]
        return GoalsAndScenesStatedInPrompts(
            {i: self.beliefs[i].with_goals_of(source_of_goals.beliefs[i]) for i in shared},
            self.experiment.combine(source_of_goals.experiment),
            f"{self.missing_reason}, or {source_of_goals.missing_reason}",
            {i: {**self.metadata.get(i, {}), **source_of_goals.metadata.get(i, {})} for i in shared},
            {
                i: _merge_study_summaries(self.summaries.get(i, {}), source_of_goals.summaries.get(i, {}))
                for i in {**self.summaries, **source_of_goals.summaries}
            },
            source_of_goals.perceive_changed_scene or self.perceive_changed_scene,
        )

    @property
    def tasks_with_stated_goals(self) -> dict[str, Task]:
        """Mapping from ids to tasks whose questions state goals from an earlier answer of a model.

        The tasks have these goals instead of their own.
        """
        return {i: belief.task for i, belief in self.beliefs.items() if STATED in self.metadata.get(i, {})}

    def make_prompts_stating_goals_and_scenes(
        self, library: PromptLibrary, suite: Suite, task_ids: Iterable[str]
    ) -> dict[str, Prompt]:
        """Return a mapping from task ids to questions that state goals or scenes as a model understood them.

        Tasks whose goals or scene the model did not state are left out.

        Raises:
            InputError: the published prompts cannot state such goals or scenes.
        """
        beliefs = {task_id: self.beliefs[task_id] for task_id in task_ids if task_id in self.beliefs}
        prompts = library.open(suite.benchmark, suite.ability, beliefs)
        return {task_id: prompts[task_id] for task_id in beliefs}

    def add_experiment_and_study_summaries(self, record: Record) -> Record:
        """Return the record with the options of its run, and with values on the beliefs in its question.

        Beliefs are goals or a scene as a model understood them. The values, such as the number of errors in a
        scene, come from studies.
        """
        experiment = (record.experiment or Experiment()).combine(self.experiment)
        summaries = _merge_study_summaries(record.summaries, self.summaries.get(record.task_id, {}))
        return replace(record, experiment=experiment, summaries=summaries)


def _merge_study_summaries(
    first: Mapping[str, Mapping[str, Any]], second: Mapping[str, Mapping[str, Any]]
) -> dict[str, Mapping[str, Any]]:
    return {name: {**first.get(name, {}), **second.get(name, {})} for name in {**first, **second}}


def add_experiment_and_belief_statistics(
    record: Record, beliefs: GoalsAndScenesStatedInPrompts | None, experiment: Experiment
) -> Record:
    """Return the record with the options of its run.

    If the question stated beliefs (`GoalsAndScenesStatedInPrompts`), the record also gets the values that
    studies report on the beliefs, such as the number of errors in a scene.
    """
    return (record if beliefs is None else beliefs.add_experiment_and_study_summaries(record)).add_experiment(
        experiment
    )


@dataclass(frozen=True, slots=True)
class ModelAnswers:
    """The answers of a model to a suite, the tasks of one ability in a benchmark.

    A model may answer in several epochs (rounds of answers to all tasks).

    Attributes:
        model: name of the model.
        name: the model's name as part of file names.
        prompts: mapping from each task to its question.
        answers: mapping from task and epoch to the answer.
        failures: mapping from task and epoch to the reason why the answer is missing.
        epochs: number of answers requested for each task.
        trials: object that executed the answers and asked again after failures; None if each question was
            sent once.
        attempts: mapping from task and epoch to all attempts, if the model has several attempts at a task.
        beliefs: goals or scenes as a model understood them, which questions stated instead of the true ones;
            tasks without any are in ``failures``.
        experiment: the options of the run's studies (variations of its questions), as in records.
        summarize: function that adds the summaries of studies to a record.
        logs: mapping from each asked task to Inspect's log of its answers, in order. A log also has answers
            that an earlier start of the run recorded.
    """

    model: str
    name: str
    prompts: Mapping[str, Prompt]
    answers: Mapping[TaskIdAndEpoch, Answer]
    failures: Mapping[TaskIdAndEpoch, str]
    epochs: int
    trials: ReplanningConversationFactory | None = None
    attempts: Mapping[TaskIdAndEpoch, Sequence[Attempt]] = field(default_factory=dict)
    beliefs: GoalsAndScenesStatedInPrompts | None = None
    experiment: Experiment = field(default_factory=Experiment)
    summarize: Callable[[Record], Record] = replace
    logs: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SuiteResult:
    """The scores of one model's answers to a suite (one ability in a benchmark).

    Attributes:
        model: name of the model.
        folder: folder of the results.
        suite: the tasks that were scored.
        totals: the totals of the records.
        records: a record (scored answer) of every task, in order. Only the files have the explanations.
        by_epoch: the result of each epoch (round of answers to all tasks), if there are several.
        remarks: sentences to print at the end of the run, such as on request options that the server ignored.
    """

    model: str
    folder: Path
    suite: Suite
    totals: RunTotals
    records: Sequence[Record]
    by_epoch: Sequence[SuiteResult] = ()
    remarks: tuple[str, ...] = ()

    @property
    def task_ids_by_failure_reason(self) -> dict[str, list[str]]:
        """Mapping from each reason for a missing answer to the ids of the tasks without an answer."""
        unanswered = [
            (record.unanswered, record.task_id)
            for record in self._records_used_by_metrics
            if record.unanswered is not None
        ]
        return group_pairs(dict.fromkeys(unanswered))

    @property
    def truncated_answer_count(self) -> int:
        """Number of answers that a length limit cut off."""
        return sum(record.is_cut_off for record in self._records_used_by_metrics)

    @property
    def usage(self) -> AnswerUsage:
        """The tokens, cost and time of all answers."""
        origins = [record.origin for record in self.map_keys_to_records().values()]
        return sum([origin.usage for origin in origins if origin and origin.usage], AnswerUsage())

    @property
    def _records_used_by_metrics(self) -> Collection[Record]:
        """The records from which the metrics are computed.

        If the ability takes the mean over the answers to a task, these are the records of all epochs.
        Otherwise they are one record for each task.
        """
        averaged = get_declaration(self.suite.ability).combine_epochs is not None
        return self.map_keys_to_records().values() if averaged else self.records

    def map_keys_to_records(self) -> dict[TaskIdAndEpoch, Record]:
        """Return a mapping from task and epoch (round of answers) to the record of the answer."""
        epochs = enumerate(self.by_epoch or (self,), 1)
        return {(record.task_id, epoch): record for epoch, result in epochs for record in result.records}

    def read_records_by_epoch(self) -> Sequence[Iterator[Record]]:
        """Return an iterator over the records of each epoch (round of answers), from the result files.

        An iterator raises InputError if its file cannot be read.
        """
        return [read_records(result.folder / RECORDS) for result in self.by_epoch or (self,)]

    def map_tasks_to_epoch_of_recorded_answer(self) -> dict[str, int]:
        """Return for each task the first epoch (round of answers) whose answer is the one in `records`."""
        shown: dict[str, int] = {}
        responses = {record.task_id: record.response for record in self.records}
        for (task_id, epoch), record in self.map_keys_to_records().items():
            if record.response == responses[task_id]:
                shown.setdefault(task_id, epoch)
        return shown

    def make_summary_fields_except_metrics(self) -> dict[str, Json]:
        """Return the values of ``summary.json`` other than metrics, such as tokens and missing answers."""
        return {
            "answered": self.totals.coverage.answered,
            "not_answered": {
                why: list(task_ids) for why, task_ids in self.task_ids_by_failure_reason.items()
            },
            "truncated": self.truncated_answer_count,
            "usage": dataclass_to_json(self.usage),
            "per_success": make_json_of_cost_per_success(
                group_costs_and_successes_by_cost_unit([*self.map_keys_to_records().values()])
            ),
            **(
                {
                    "passes": pass_at_k_to_json(
                        map_pass_at_k_metrics_to_contributions(self.success_rate_contributions_by_epoch)
                    )
                }
                if self.by_epoch
                else {}
            ),
        }

    @property
    def success_rate_contributions_by_epoch(self) -> Sequence[TaskRateContributions]:
        """The contributions of answers (`TaskRateContribution`) to the share of right answers, by epoch.

        Empty if the run has no epochs, or the ability has no metric for whole answers.
        """
        ability = self.suite.ability
        metric = find_success_metric(ability)
        if metric is None:
            return ()
        return [
            make_contributions_by_metric(result.records, ability).get(metric, ()) for result in self.by_epoch
        ]


def score_answers(
    model_answers: ModelAnswers,
    folder: Path,
    suite: Suite,
    scoring: ScoringOptions,
    progressed: ProgressCallback | None = None,
) -> SuiteResult:
    """Score answers and write the results: of each round of answers, if there are several, and of all.

    Raises:
        InputError: the folder cannot be written.
    """
    epoch_results = [
        score_answers(
            _select_answers_of_epoch(model_answers, epoch),
            folder / f"epoch_{epoch}",
            suite,
            scoring,
            progressed,
        )
        for epoch in range(1, model_answers.epochs + 1)
        if model_answers.epochs > 1
    ]
    average = get_declaration(suite.ability).combine_epochs
    if epoch_results and average is not None:
        of_epochs = [read_records(result_of_epoch.folder / RECORDS) for result_of_epoch in epoch_results]
        means = average_records_over_epochs(of_epochs, average)
        scored = iter([replace(record, model=model_answers.name) for record in means])
    else:
        scored = _score_model_answers(model_answers, folder, suite, scoring, progressed)
    records: list[Record] = []

    def make_batches() -> Iterator[RecordBatch]:
        while batch := list(islice(scored, MAX_BATCH_RECORDS)):
            records.extend([record.drop_explanations() for record in batch])
            yield make_record_batch(batch)

    def make_run_details_and_rates_by_attempt(totals: RunTotals) -> RunDetailsAndRatesByAttempt:
        result = SuiteResult(model_answers.model, folder, suite, totals, records, epoch_results)
        digests = [(task_id, prompt.sha256) for task_id, prompt in model_answers.prompts.items()]
        run_fields = {
            "prompts_sha256": hash_text(json.dumps(digests)),
            **result.make_summary_fields_except_metrics(),
        }
        return run_fields, compute_rates_by_attempt(records)

    totals = write_record_batches(folder, make_batches(), make_run_details_and_rates_by_attempt)
    return SuiteResult(model_answers.model, folder, suite, totals, records, epoch_results)


def _select_answers_of_epoch(model_answers: ModelAnswers, epoch: int) -> ModelAnswers:
    """Return the answers of one epoch (round of answers to all tasks), as if it were the only epoch."""
    answers = {key: answer for key, answer in model_answers.answers.items() if key[1] == epoch}
    failures = {key: reason for key, reason in model_answers.failures.items() if key[1] == epoch}
    name = f"{model_answers.name}.epoch_{epoch}"
    return replace(model_answers, name=name, answers=answers, failures=failures, epochs=1)


def average_records_over_epochs(
    records_by_epoch: Iterable[Iterable[Record]], average: Callable[[Sequence[Verdict]], Verdict]
) -> list[Record]:
    """Return one record for each task, with the mean of each metric over the answers of all epochs."""
    by_task = group_pairs((record.task_id, record) for record in chain.from_iterable(records_by_epoch))
    return [_average_records_of_task(of_task, average) for of_task in by_task.values()]


def _average_records_of_task(
    records: Sequence[Record], average: Callable[[Sequence[Verdict]], Verdict]
) -> Record:
    """Return a task's first record that is not excluded, with the mean metrics of all records of the task."""
    shown, *others = sorted(records, key=lambda r: (r.verdict.excluded is not None, r.unanswered is not None))
    return replace(shown, verdict=average([record.verdict for record in (shown, *others)]))


def _choose_majority_answers(model_answers: ModelAnswers, ability: Ability) -> dict[str, Answer]:
    in_order = sorted(model_answers.answers.values(), key=attrgetter("epoch"))
    by_task = group_pairs((answer.task_id, answer) for answer in in_order)
    chosen = {
        i: select_item_with_majority_answer(
            given, [answer.text for answer in given], model_answers.epochs, ability
        )
        for i, given in by_task.items()
    }
    return {i: answer for i, answer in chosen.items() if answer is not None}


def select_item_with_majority_answer(
    items: Sequence[T], answers: Sequence[str], epochs: int, ability: Ability
) -> T | None:
    """Return the item whose answer is chosen by `find_majority_index`.

    Missing answers and answers that cannot be read are failed attempts. If failed attempts are most frequent,
    return the first item with such an answer, or None if all of these answers are missing.

    Args:
        items: the items to choose from, such as samples of a log.
        answers: the answer of each item.
        epochs: number of answers that were requested. Missing answers count as the last ones: if meanings are
            equally frequent, the meaning of the first answer wins.
        ability: the ability.
    """
    missing = [None] * (epochs - len(answers))
    return [*items, *missing][find_majority_index([*answers, *missing], ability)]


def _score_model_answers(
    model_answers: ModelAnswers,
    folder: Path,
    suite: Suite,
    scoring: ScoringOptions,
    on_progress: ProgressCallback | None,
) -> Iterator[Record]:
    answers = _choose_majority_answers(model_answers, suite.ability)
    failed = {task_id: reason for (task_id, _), reason in model_answers.failures.items()}
    why = {
        i: failed.get(i, "the run ended before")
        for i in (*model_answers.prompts, *failed)
        if i not in answers
    }
    if model_answers.trials is None:
        given = tuple([Response(i, answers[i].text) for i in model_answers.prompts if i in answers])
        file = ResponseFile(model_answers.name, given)
        write_responses(folder, file)
        records: Iterable[Record] = generate_run_records(suite, file, why, scoring, on_progress)
    else:
        unanswered = score_run(model_answers.trials.suite, ResponseFile(model_answers.name, ()), why, scoring)
        tried = _make_multi_attempt_records(model_answers, model_answers.trials, answers, unanswered)
        records = tried if scoring.explanations else [record.drop_explanations() for record in tried]
        _write_attempt_files(folder, model_answers.name, tried)
    for record in records:
        believed = add_experiment_and_belief_statistics(
            record, model_answers.beliefs, model_answers.experiment
        )
        yield model_answers.summarize(
            _add_generation_details_and_mark_cut_off(believed, model_answers, answers)
        )


def _make_multi_attempt_records(
    model_answers: ModelAnswers,
    trials: ReplanningConversationFactory,
    last_answers: Mapping[str, Answer],
    unanswered_records: Iterable[Record],
) -> list[Record]:
    """Return the records of a run with several attempts at each task.

    ``last_answers`` is a mapping from each answered task to the answer after all attempts.
    """
    suite, options = trials.suite, trials.options
    by_task = {
        record.task_id: replace(record, experiment=options.experiment) for record in unanswered_records
    }
    for task_id, answer in last_answers.items():
        attempts = model_answers.attempts[task_id, answer.epoch]
        by_task[task_id] = make_trial_record(suite, options, model_answers.name, task_id, attempts)
    return [by_task[task_id] for task_id in suite.task_ids if task_id in by_task]


def _add_generation_details_and_mark_cut_off(
    record: Record, model_answers: ModelAnswers, scored_answers: Mapping[str, Answer]
) -> Record:
    """Return the record with the source of its answer, and with the tokens and cost of all attempts."""
    answer, prompt = scored_answers.get(record.task_id), model_answers.prompts.get(record.task_id)
    if answer is None:
        return replace(record, origin=AnswerOrigin(None if prompt is None else prompt.sha256))
    spent = [attempt.usage or AnswerUsage() for attempt in record.attempts] or [answer.usage]
    usage = sum(spent, AnswerUsage())
    fields = answer.prompt_sha256, answer.stop_reason, answer.is_cut_off, usage, answer.repairs
    if answer.is_cut_off and record.protocol is DEFAULT_PROTOCOL:
        verdict, explanation = mark_as_cut_off(record.verdict, record.explanation)
        record = replace(record, verdict=verdict, explanation=explanation)
    return replace(record, origin=AnswerOrigin(*fields))


def _write_attempt_files(folder: Path, name: str, records: Sequence[Record]) -> None:
    for number in range(max((len(record.attempts) for record in records), default=0)):
        made = [(r.task_id, r.attempts[number].response) for r in records if number < len(r.attempts)]
        responses = tuple([Response(task_id, text) for task_id, text in made])
        write_responses(folder, ResponseFile(format_attempt_name(name, number + 1), responses))
