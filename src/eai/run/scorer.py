"""Scorers and a metric for Inspect: a score is a verdict, the metric has the columns of the paper's tables.

A score tells whether the whole answer is right (``C`` or ``I``), for Inspect's own metrics and reducers. The
score's metadata is the record of the answer; the metric adds up the contributions of all records. The score's
explanation, which Inspect's viewer shows, is the record's explanation in Markdown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import nan
from typing import Any, TypeAlias

from inspect_ai.scorer import (
    CORRECT,
    INCORRECT,
    Metric,
    SampleScore,
    Score,
    Scorer,
    Target,
    Value,
    accuracy,
    metric,
    scorer,
    stderr,
)
from inspect_ai.solver import TaskState

from eai.abilities.declaration import AnswerOutcome, get_declaration, get_display_name
from eai.abilities.experiment import RULES_SEPARATOR, Experiment
from eai.abilities.explanation import GoalPartReport, StepReport, VerdictExplanation
from eai.abilities.protocol import Ability, Protocol, find_ability_entry_points
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.verdict import Verdict
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import Scoring
from eai.results.codec import experiment_from_json, record_from_json, record_to_json
from eai.results.epochs import find_majority_index
from eai.results.record import Record
from eai.results.responses import Response
from eai.results.runs import make_explorer_url_fragment
from eai.results.summary import compute_metric_rates, find_answer_outcome
from eai.results.trials import make_trial_record, replay_attempts_at_task
from eai.run.acting import read_episode_text
from eai.run.solver import ANSWERS
from eai.studies.registry import add_study_summaries
from eai.tasks.source import ErrataChoice, Source, find_errata_choice, find_planner_choice

_MARK = {True: "✓", False: "✗"}


def explain_record(record: Record) -> str:
    """Return the outcome of an answer with reasons in Markdown, and its steps if the record has them."""
    explanation = record.explanation or VerdictExplanation()
    steps = enumerate(explanation.steps, 1)
    sections = (
        ("", [f"- {note}" for note in explanation.notes]),
        (
            "Steps\n",
            [f"{number}. `{step.action}`: {'; '.join(_describe_step(step))}" for number, step in steps],
        ),
        ("Goals\n", [f"- {_MARK[goal.satisfied]} {goal.kind} `{goal.goal}`" for goal in explanation.goals]),
        (
            "Temporal goal\n",
            [f"- {_describe_goal_part(part, i)}" for i, part in enumerate(explanation.parts)],
        ),
    )
    written = ["\n".join(filter(None, [title, *lines])) for title, lines in sections if lines]
    return "\n\n".join([f"**{_write_first_line_of_explanation(record)}**", *written])


def _write_first_line_of_explanation(record: Record) -> str:
    verdict, answer_outcome = record.verdict, find_answer_outcome(record)
    if answer_outcome is AnswerOutcome.EXCLUDED:
        return f"Excluded: {verdict.excluded}"
    label = get_display_name(answer_outcome.value)
    if answer_outcome is AnswerOutcome.NOT_ANSWERED:
        return f"{label}: {record.unanswered}"
    if verdict.error is None or answer_outcome is AnswerOutcome.SUCCESS:
        return label
    return f"{label}: {verdict.error.detail}"


def _describe_step(step: StepReport) -> Iterator[str]:
    yield f"{get_display_name(step.outcome).lower()}, {step.reason}" if step.reason else step.outcome
    if step.earlier:
        yield step.earlier
    for sign, facts in (("+", step.added), ("-", step.removed)):
        yield from (f"{sign} `{fact}`" for fact in facts)
    if step.hidden_changes:
        yield f"{step.hidden_changes} more change{'' if step.hidden_changes == 1 else 's'}, not shown"


def _describe_goal_part(part: GoalPartReport, number: int) -> str:
    if part.met_after is not None:
        return f"✓ `{part.part}`, {part.first_met_time_text}"
    never = "never after that" if number else "never"
    missing_text = f", {never}: {', '.join([f'`{text}`' for text in part.missing])}" if part.missing else ""
    return f"✗ `{part.part}`{missing_text}"


@metric(name="paper", scores="unreduced")
def make_inspect_metric_of_paper_scores(ability: str) -> Metric:
    """Return Inspect's metric with the columns of the paper's tables, as fractions.

    A fraction is a sum over all tasks divided by another sum, as in ``summary.json``. Columns to which no
    answer contributes are left out. If a task has several answers, their mean counts, or the answer with the
    most frequent meaning, as in ``eai run --epochs``.

    Some protocols (scoring rules) look at all answers of a model to tell whether plans name objects with ids.
    For such a protocol, the answers are scored again.
    """

    def compute_metrics_of_paper(scores: list[SampleScore]) -> Value:
        ability_of_scores = Ability.from_name(ability)
        ordered = sorted(scores, key=lambda score: int(_get_metadata(score)["epoch"]))
        by_task = group_pairs((str(score.sample_id), score) for score in ordered).values()
        average = get_declaration(ability_of_scores).combine_epochs
        if average is None:
            verdicts = _read_verdicts(
                [_select_majority_score(of_task, ability_of_scores) for of_task in by_task]
            )
        else:
            verdicts = [average([_read_verdict(score) for score in of_task]) for of_task in by_task]
        shares = {
            name: rate.share for name, rate in compute_metric_rates(verdicts, ability_of_scores).items()
        }
        return shares if scores else dict.fromkeys(shares, nan)

    return compute_metrics_of_paper


def _register_scorer(ability: Ability) -> Callable[..., Scorer]:
    @scorer(
        metrics=[make_inspect_metric_of_paper_scores(ability.value), accuracy(), stderr()], name=ability.value
    )
    def make_verdict_scorer(
        benchmark: str, protocol: str, planner: str, errata: str = ErrataChoice.CURRENT.value
    ) -> Scorer:
        """Return an Inspect scorer that calls this package's scoring function.

        Args:
            benchmark: reference of the benchmark (`find_benchmark`).
            protocol: the rules for scoring.
            planner: the planner that judges operators.
            errata: whether known errors of the data are corrected.
        """

        async def score(state: TaskState, target: Target) -> Score:
            suite = _open_suite(find_benchmark(benchmark), ability, protocol, planner, errata)
            return make_score(_make_record(state, suite), state.epoch, answered=bool(state.output.choices))

        return score

    return make_verdict_scorer


EXPERIMENT = "experiment"
"""Name of the field with the options of studies (variations of questions), in samples and in records."""

SCORERS = {ability: _register_scorer(ability) for ability in find_ability_entry_points()}
"""Mapping from abilities to their scorers; the score of a sample has the ability's name."""


def _make_record(state: TaskState, suite: Suite) -> Record:
    model, task_id = to_file_name(str(state.model)), str(state.sample_id)
    if state.output.choices:
        text = (
            read_episode_text(state)
            if get_declaration(suite.ability).takes_turns
            else state.output.completion
        )
        answer = Response(task_id, text)
    else:  # Inspect also scores samples of failed requests
        answer = Response(task_id, "", unanswered="the request failed")
    record = next(Scoring().score_records(suite, model, [answer], explanations=answer.unanswered is None))
    return add_study_results_to_record(
        record, suite.choose_suite_for_answers([state.input_text]), state.metadata, state.epoch
    )


def _add_harness_and_game_rules_of_episode(log_experiment: Experiment, record: Record) -> Experiment:
    """Return the options of a log, with an episode's harness (program that let the model act) and game rules.

    If the log's rules include all rules of the episode, the log's rules are kept. They may also include
    limits that an episode does not record, such as a token limit. Otherwise, the episode's rules replace
    them.
    """
    agent = (
        get_declaration(record.ability).read_episode_settings(record.response)
        or record.experiment
        or Experiment()
    )
    in_episode, in_log = (
        {*(rules or "").split(RULES_SEPARATOR)} - {""} for rules in (agent.rules, log_experiment.rules)
    )
    rules = log_experiment.rules if in_episode <= in_log else agent.rules
    return replace(log_experiment, harness=agent.harness or log_experiment.harness, rules=rules)


def add_study_results_to_record(
    record: Record, suite: Suite, metadata: Mapping[str, Any], epoch: int
) -> Record:
    """Add the options and results of studies (variations of questions) to the record of an answer in a log.

    The options, called the experiment, are read from the metadata of the answer's sample. Without options,
    the record is returned unchanged. If the task had several attempts, their answers are executed again. If
    the question stated goals or a scene that a model gave earlier, the studies' values on these are computed
    again.

    Args:
        record: the record of the last answer, scored as if there were no experiment.
        suite: the suite, adapted to the model's answers (`Suite.choose_suite_for_answers`).
        metadata: metadata of the sample.
        epoch: epoch of the sample.
    """
    written = metadata.get(EXPERIMENT)
    if written is None:
        return record
    stated = experiment_from_json(written) or Experiment()
    experiment, task_id = _add_harness_and_game_rules_of_episode(stated, record), record.task_id
    if record.unanswered is not None:
        return replace(record, experiment=experiment)
    options = ReplanningOptions.from_experiment(experiment)
    if options is not None:
        attempts = replay_attempts_at_task(suite, options, task_id, metadata[ANSWERS], epoch)
        record = make_trial_record(suite, options, record.model, task_id, attempts)
    return add_study_summaries(replace(record, experiment=experiment), suite, metadata)


LoggedSamples: TypeAlias = Mapping[str, tuple[Mapping[str, Any], int, str]]
"""Mapping from each task to metadata, epoch (round of answers) and question of the scored sample."""


def add_logged_study_results_to_record(
    suite: Suite, default_study_options: Mapping[str, Any], samples: LoggedSamples, record: Record
) -> Record:
    """Add the options and results of studies (variations of questions) to the record of a logged answer.

    The options are called the experiment. Those in the metadata of the task's sample are used.

    Args:
        suite: the suite.
        default_study_options: the options for a task without a sample in ``samples``, in the form of samples'
            metadata.
        samples: the logged sample of each task whose answer is scored.
        record: the answer's record, scored as if the run had no studies.
    """
    metadata, epoch, question = samples.get(record.task_id, ({EXPERIMENT: default_study_options}, 1, ""))
    logged = add_study_results_to_record(record, suite.choose_suite_for_answers([question]), metadata, epoch)
    return logged.drop_explanations() if record.explanation is None else logged


def make_score(record: Record, epoch: int, *, answered: bool) -> Score:
    """Return the Inspect score of a record (scored answer); an excluded answer has no score, but a reason."""
    answer_outcome = find_answer_outcome(record)
    fields = record_to_json(record.drop_explanations())
    score = Score.unscored(
        reason=record.verdict.excluded,
        answer=str(fields.pop("response")),
        explanation=explain_record(record),
        metadata={
            "epoch": epoch,
            "answered": answered,
            "explorer": make_explorer_url_fragment(record),
            **fields,
        },
    )
    if answer_outcome is not AnswerOutcome.EXCLUDED:
        score.value = CORRECT if answer_outcome is AnswerOutcome.SUCCESS else INCORRECT
    return score


@cache
def _open_suite(benchmark: Benchmark, ability: Ability, protocol: str, planner: str, errata: str) -> Suite:
    source = Source(planner=find_planner_choice(planner), errata=find_errata_choice(errata))
    return open_suite(benchmark, ability, Protocol.from_name(protocol), source=source)


RECORD = "record"
"""Key in a score's metadata, whose value is the `Record`.

A score that is read from a log lacks this key: its metadata has the fields of the record instead.
"""


def _get_metadata(score: SampleScore) -> dict[str, Any]:
    return score.score.metadata or {}


def _get_record(score: SampleScore) -> Record:
    metadata = _get_metadata(score)
    record: Record = metadata.get(RECORD) or record_from_json(metadata)
    return record


def _select_answered_scores(scores: Iterable[SampleScore]) -> list[SampleScore]:
    return [score for score in scores if _get_metadata(score)["answered"]]


def _select_majority_score(scores: Sequence[SampleScore], ability: Ability) -> SampleScore:
    """Return one of a task's scores: that of the answer whose meaning is the most frequent."""
    in_order = sorted(scores, key=lambda score: not _get_metadata(score)["answered"])
    answers = [score.score.answer or "" if _get_metadata(score)["answered"] else None for score in in_order]
    return in_order[find_majority_index(answers, ability)]


def _read_verdicts(scores: Sequence[SampleScore]) -> list[Verdict]:
    """Return the verdict on each task, which is read from one score of the task.

    Under some protocols (scoring rules), all answers of a model determine the scorers. If the log was scored
    by other scorers, all answers are scored again. Verdicts on repeated attempts do not change, because each
    answer was scored before the next question.
    """
    texts = {str(score.sample_id): score.score.answer or "" for score in _select_answered_scores(scores)}
    verdicts = {str(score.sample_id): _read_verdict(score) for score in scores}
    if texts and not any(_get_record(score).attempts for score in scores):
        suite = _open_suite_of_score(scores[0])
        suite_of_answers = suite.choose_suite_for_answers(list(texts.values()))
        if suite_of_answers is not suite:
            verdicts |= {task_id: suite_of_answers.score(task_id, text) for task_id, text in texts.items()}
    return list(verdicts.values())


def _read_verdict(score: SampleScore) -> Verdict:
    return _get_record(score).verdict


def _open_suite_of_score(score: SampleScore) -> Suite:
    benchmark, record = (score.sample_metadata or {})["domain"], _get_record(score)
    errata = ErrataChoice.NONE if record.errata is None else ErrataChoice.CURRENT
    rules = (record.protocol.value, PlannerChoice.NONE.value, errata.value)
    return _open_suite(find_benchmark(benchmark), record.ability, *rules)
