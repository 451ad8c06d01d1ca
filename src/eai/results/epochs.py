"""From a model's answers to records: of each epoch, where there are several, and of all together.

As its ability declares, a task counts by the mean over its epochs, or by the majority. The majority is
self-consistency: of several answers to a task, one that says what most of them say.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import Any

from eai.abilities.answer_text import ANY_VALUE, JsonObject, ParsedAnswer, read_json
from eai.abilities.attempt import Attempt, Usage
from eai.abilities.declaration import Interaction, declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.feedback import ScenePerception
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Verdict
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.suite import Suite
from eai.results.batch import ProgressCallback, score_run
from eai.results.certainty import Cases
from eai.results.codec import dataclass_to_json, sha256_of
from eai.results.cost import cost_cases, cost_cases_to_json
from eai.results.options import ScoringOptions
from eai.results.record import Origin, Record
from eai.results.records import make_record_batch, write_record_batches
from eai.results.repeats import find_success_metric, pass_cases, pass_cases_to_json
from eai.results.responses import Response, ResponseFile, attempt_name, write_responses
from eai.results.summary import cases_of, summarise_by_attempt
from eai.results.totals import Totals
from eai.results.trials import Answer, AnswerKey, Trials, make_trial_record
from eai.tasks.prompts.prompt import Belief, Prompt
from eai.tasks.task import Task


def majority_index(answers: Sequence[str], ability: Ability) -> int:
    """The index of the first answer that means what most readable ones mean.

    Of meanings that are equally frequent the one that was given first counts. If none can be read, the
    first answer is taken.
    """
    meanings = [meaning(text, ability) for text in answers]
    counts = Counter(each for each in meanings if each is not None)
    return meanings.index(counts.most_common(1)[0][0]) if counts else 0


def meaning(text: str, ability: Ability) -> str | None:
    """An answer without what does not matter, so that equal answers are equal texts; None if unreadable.

    What does not matter is declared by the ability (`Asked`).
    """
    asked = declaration_of(ability).interaction
    reading = read_json(text, ANY_VALUE)
    if isinstance(reading, ParsedAnswer):
        return _text(reading.value, asked)
    start = -1 if asked.plain_text_prefix is None else text.find(asked.plain_text_prefix)
    return _spaced(text[start:]) if start >= 0 else None


def _text(value: object, asked: Interaction) -> str:
    if isinstance(value, JsonObject):
        members = [f"{json.dumps(key)}:{_text(each, asked)}" for key, each in value.members]
        return "{" + ",".join(members if asked.keys_in_order else sorted(members)) + "}"
    if isinstance(value, list):
        elements = [_text(each, asked) for each in value]
        is_goal = all(isinstance(each, str) for each in value)  # such as ["inside", "rag", "bucket"]
        is_set = asked.lists_are_sets and not is_goal
        return "[" + ",".join(sorted(elements) if is_set else elements) + "]"
    return json.dumps(_spaced(value) if isinstance(value, str) else value)


def _spaced(text: str) -> str:
    return " ".join(text.split())


STATED = "stated"
"""The field of a question's metadata that has the answer whose goals it states instead of the task's."""


SUBGOALS = "subgoals"
"""The field of a question's metadata that has the answer whose subgoals it states."""


@dataclass(frozen=True, slots=True)
class BeliefSet:
    """The beliefs that questions state in the place of the facts: goals in a pipeline, or perceived scenes.

    Attributes:
        beliefs: what each question states, by task.
        experiment: the experiment of a run that asks so.
        lacking: why a task without a belief is not asked.
        about: the metadata of questions for built-in models, by task.
        summaries: what studies say of answers to these questions, by task and study.
        look: how a scene that has changed is perceived; None if it is told as it is.
    """

    beliefs: Mapping[str, Belief]
    experiment: Experiment
    missing_reason: str
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    summaries: Mapping[str, Mapping[str, Mapping[str, Any]]] = field(default_factory=dict)
    look: ScenePerception | None = None

    def combine(self, goals: BeliefSet) -> BeliefSet:
        """Return these scenes with other goals in them; a task needs both.

        Raises:
            InputError: both change the same thing.
        """
        shared = [task_id for task_id in goals.beliefs if task_id in self.beliefs]
        return BeliefSet(
            {i: self.beliefs[i].with_goals(goals.beliefs[i]) for i in shared},
            self.experiment.combine(goals.experiment),
            f"{self.missing_reason}, or {goals.missing_reason}",
            {i: {**self.metadata.get(i, {}), **goals.metadata.get(i, {})} for i in shared},
            {
                i: _merged(self.summaries.get(i, {}), goals.summaries.get(i, {}))
                for i in {**self.summaries, **goals.summaries}
            },
            goals.look or self.look,
        )

    @property
    def goals(self) -> dict[str, Task]:
        """The tasks with the goals that questions state instead of their own, by id."""
        return {i: each.task for i, each in self.beliefs.items() if STATED in self.metadata.get(i, {})}

    def prompts(self, library: Library, suite: Suite, task_ids: Iterable[str]) -> dict[str, Prompt]:
        """The questions of those of the tasks that have a belief.

        Raises:
            InputError: published prompts cannot state it.
        """
        beliefs = {task_id: self.beliefs[task_id] for task_id in task_ids if task_id in self.beliefs}
        prompts = library.open(suite.benchmark, suite.ability, beliefs)
        return {task_id: prompts[task_id] for task_id in beliefs}

    def mark(self, record: Record) -> Record:
        """The record of an answer to such a question."""
        varied = (record.experiment or Experiment()).combine(self.experiment)
        summaries = _merged(record.summaries, self.summaries.get(record.task_id, {}))
        return replace(record, experiment=varied, summaries=summaries)


def _merged(
    one: Mapping[str, Mapping[str, Any]], other: Mapping[str, Mapping[str, Any]]
) -> dict[str, Mapping[str, Any]]:
    return {name: {**one.get(name, {}), **other.get(name, {})} for name in {**one, **other}}


def finish_record(record: Record, believed: BeliefSet | None, experiment: Experiment) -> Record:
    """Return a record with what its question stated and the choices of its run."""
    return (record if believed is None else believed.mark(record)).add_experiment(experiment)


@dataclass(frozen=True, slots=True)
class ModelAnswers:
    """The answers of a model to a suite.

    Attributes:
        model: the model's name.
        name: the same as part of file names.
        prompts: what it was asked, by task.
        given: the answers by task and epoch.
        failures: for every task and epoch without an answer, why.
        epochs: how many answers to each task were asked for.
        trials: how answers were carried out in an experiment; None where each question was asked once.
        tried: in an experiment all attempts, by task and epoch.
        believed: what the questions stated in the place of the facts: goals in a pipeline, perceived scenes;
            ``failures`` has the tasks without any.
        experiment: further choices of the run, as records have them.
        summarized: adds the summaries of studies to a record.
        log: Inspect's log of all answers, those included that were in the journal before.
    """

    model: str
    name: str
    prompts: Mapping[str, Prompt]
    answers: Mapping[AnswerKey, Answer]
    failures: Mapping[AnswerKey, str]
    epochs: int
    trials: Trials | None = None
    attempts: Mapping[AnswerKey, Sequence[Attempt]] = field(default_factory=dict)
    beliefs: BeliefSet | None = None
    experiment: Experiment = field(default_factory=Experiment)
    summarize: Callable[[Record], Record] = replace
    log: Path = Path()


@dataclass(frozen=True, slots=True)
class SuiteResult:
    """The result of one model on one suite.

    Attributes:
        model: the model's name.
        folder: where its results are.
        suite: what was scored.
        totals: what its records come to.
        records: a record of every task that was asked, in order.
        of_epochs: the same of each epoch, where there are several.
    """

    model: str
    folder: Path
    suite: Suite
    totals: Totals
    records: Sequence[Record]
    by_epoch: Sequence[SuiteResult] = ()

    @property
    def failures(self) -> dict[str, list[str]]:
        """The tasks that have no answer, by the reason why."""
        lacking = [(each.unanswered, each.task_id) for each in self._counted if each.unanswered is not None]
        return group_pairs(dict.fromkeys(lacking))

    @property
    def truncated(self) -> int:
        """How many answers were cut off."""
        return sum(bool(each.origin and each.origin.truncated) for each in self._counted)

    @property
    def usage(self) -> Usage:
        """The effort that all answers took."""
        origins = [record.origin for record in self.records_by_key().values()]
        return sum([each.usage for each in origins if each and each.usage], Usage())

    @property
    def _counted(self) -> Collection[Record]:
        """The records of the answers that count: those of all epochs where a task counts by their mean."""
        averaged = declaration_of(self.suite.ability).combine_epochs is not None
        return self.records_by_key().values() if averaged else self.records

    def records_by_key(self) -> dict[AnswerKey, Record]:
        """The record of every answer that was asked for."""
        epochs = enumerate(self.by_epoch or (self,), 1)
        return {(record.task_id, epoch): record for epoch, one in epochs for record in one.records}

    def epochs_shown(self) -> dict[str, int]:
        """Of each task the epoch whose answer its record has."""
        shown: dict[str, int] = {}
        responses = {record.task_id: record.response for record in self.records}
        for (task_id, epoch), record in self.records_by_key().items():
            if record.response == responses[task_id]:
                shown.setdefault(task_id, epoch)
        return shown

    def effort(self) -> dict[str, Json]:
        """The fields of the summary besides the metrics."""
        return {
            "answered": self.totals.coverage.answered,
            "not_answered": {why: list(task_ids) for why, task_ids in self.failures.items()},
            "truncated": self.truncated,
            "usage": dataclass_to_json(self.usage),
            "per_success": cost_cases_to_json(cost_cases([*self.records_by_key().values()])),
            **({"passes": pass_cases_to_json(pass_cases(self.right_by_epoch))} if self.by_epoch else {}),
        }

    @property
    def right_by_epoch(self) -> Sequence[Cases]:
        """Which answers of each epoch are right; empty without epochs, or where none is right as a whole."""
        ability = self.suite.ability
        metric = find_success_metric(ability)
        if metric is None:
            return ()
        return [cases_of(one.records, ability).get(metric, ()) for one in self.by_epoch]


def score_answers(
    obtained: ModelAnswers,
    folder: Path,
    suite: Suite,
    scoring: ScoringOptions,
    progressed: ProgressCallback | None = None,
) -> SuiteResult:
    """Score answers and write the results: of each epoch, where there are several, and of all together.

    Raises:
        InputError: the folder cannot be written.
    """
    of_epochs = [
        score_answers(_of_epoch(obtained, epoch), folder / f"epoch_{epoch}", suite, scoring, progressed)
        for epoch in range(1, obtained.epochs + 1)
        if obtained.epochs > 1
    ]
    averaged = declaration_of(suite.ability).combine_epochs
    if of_epochs and averaged is not None:
        means = average_records([one.records for one in of_epochs], averaged)
        records = [replace(record, model=obtained.name) for record in means]
    else:
        records = _records(obtained, folder, suite, scoring, progressed)
    part = make_record_batch(records)
    result = SuiteResult(obtained.model, folder, suite, part[1], records, of_epochs)
    digests = [(task_id, prompt.sha256) for task_id, prompt in obtained.prompts.items()]
    told = {"prompts_sha256": sha256_of(json.dumps(digests)), **result.effort()}
    write_record_batches(folder, [part], told, summarise_by_attempt(records))
    return result


def _of_epoch(obtained: ModelAnswers, epoch: int) -> ModelAnswers:
    """The answers of one epoch, as if it were the only one."""
    given = {place: answer for place, answer in obtained.answers.items() if place[1] == epoch}
    failures = {place: reason for place, reason in obtained.failures.items() if place[1] == epoch}
    name = f"{obtained.name}.epoch_{epoch}"
    return replace(obtained, name=name, answers=given, failures=failures, epochs=1)


def average_records(
    of_epochs: Iterable[Iterable[Record]], averaged: Callable[[Sequence[Verdict]], Verdict]
) -> list[Record]:
    """A record of each task that has the means over its epochs."""
    by_task = group_pairs((record.task_id, record) for record in chain.from_iterable(of_epochs))
    return [_mean(of_task, averaged) for of_task in by_task.values()]


def _mean(records: Sequence[Record], averaged: Callable[[Sequence[Verdict]], Verdict]) -> Record:
    """Of one task the first record with an answer that counts, with the means of all."""
    shown, *others = sorted(records, key=lambda r: (r.verdict.excluded is not None, r.unanswered is not None))
    return replace(shown, verdict=averaged([record.verdict for record in (shown, *others)]))


def _chosen(obtained: ModelAnswers, ability: Ability) -> dict[str, Answer]:
    """Of each task's answers one that says what most of them say."""
    in_order = sorted(obtained.answers.values(), key=attrgetter("epoch"))
    by_task = group_pairs((answer.task_id, answer) for answer in in_order)
    return {i: given[majority_index([each.text for each in given], ability)] for i, given in by_task.items()}


def _records(
    obtained: ModelAnswers,
    folder: Path,
    suite: Suite,
    scoring: ScoringOptions,
    progressed: ProgressCallback | None,
) -> list[Record]:
    """The records of one answer a task, in order; the answers are written."""
    answers = _chosen(obtained, suite.ability)
    failed = {task_id: reason for (task_id, _), reason in obtained.failures.items()}
    why = {i: failed.get(i, "the run ended before") for i in (*obtained.prompts, *failed) if i not in answers}
    if obtained.trials is None:
        given = tuple([Response(i, answers[i].text) for i in obtained.prompts if i in answers])
        file = ResponseFile(obtained.name, given)
        write_responses(folder, file)
        records = score_run(suite, file, why, scoring, progressed)
    else:
        lacking = score_run(obtained.trials.suite, ResponseFile(obtained.name, ()), why, scoring)
        records = _tried(obtained, obtained.trials, answers, lacking)
        if not scoring.explanations:
            records = [record.drop_explanations() for record in records]
        _write_attempts(folder, obtained.name, records)
    records = [finish_record(record, obtained.beliefs, obtained.experiment) for record in records]
    return [obtained.summarize(_with_origin(record, obtained, answers)) for record in records]


def _tried(
    obtained: ModelAnswers, trials: Trials, answers: Mapping[str, Answer], lacking: Iterable[Record]
) -> list[Record]:
    """The records of an experiment; ``answers`` are the last ones of the trials that count."""
    suite, options = trials.suite, trials.options
    found = {record.task_id: replace(record, experiment=options.experiment) for record in lacking}
    for task_id, answer in answers.items():
        attempts = obtained.attempts[task_id, answer.epoch]
        found[task_id] = make_trial_record(suite, options, obtained.name, task_id, attempts)
    return [found[task_id] for task_id in suite.task_ids if task_id in found]


def _with_origin(record: Record, obtained: ModelAnswers, answers: Mapping[str, Answer]) -> Record:
    """The record with where its answer comes from, and what all attempts at it took."""
    answer, prompt = answers.get(record.task_id), obtained.prompts.get(record.task_id)
    if answer is None:
        return replace(record, origin=Origin(None if prompt is None else prompt.sha256))
    spent = [attempt.usage or Usage() for attempt in record.attempts] or [answer.usage]
    usage = sum(spent, Usage())
    told = answer.prompt_sha256, answer.stop_reason, answer.truncated, usage, answer.repairs
    return replace(record, origin=Origin(*told))


def _write_attempts(folder: Path, name: str, records: Sequence[Record]) -> None:
    """Write the answers of each attempt as a response file, so that the experiment can be replayed."""
    for number in range(max((len(record.attempts) for record in records), default=0)):
        made = [(r.task_id, r.attempts[number].response) for r in records if number < len(r.attempts)]
        responses = tuple([Response(task_id, text) for task_id, text in made])
        write_responses(folder, ResponseFile(attempt_name(name, number + 1), responses))
