"""Verdicts as Inspect's scores, and the paper's columns as one metric of theirs.

A score says whether an answer is right in all that was asked (``C`` or ``I``); Inspect's own metrics and
reducers work on that. Its metadata is the record, from which the metric pools what all answers contribute.
Its explanation is the record's in Markdown, which Inspect's viewer shows.
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

from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.declaration import AnswerOutcome, declaration_of, label_of
from eai.abilities.experiment import RULES_SEPARATOR, Experiment
from eai.abilities.explanation import Explanation, PartReport, StepReport
from eai.abilities.protocol import Ability, Protocol, find_abilities
from eai.abilities.verdict import Verdict
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import Scoring
from eai.results.codec import experiment_from_json, record_from_json, record_to_json
from eai.results.epochs import majority_index
from eai.results.record import Record
from eai.results.responses import Response
from eai.results.runs import explorer_address
from eai.results.summary import outcome_of, summarise
from eai.results.trials import make_trial_record, replay
from eai.run.acting import episode_text
from eai.run.solver import ANSWERS
from eai.studies.registry import summarized
from eai.tasks.source import ErrataChoice, Source, errata_choice, planner_choice

_MARK = {True: "✓", False: "✗"}


def explain_record(record: Record) -> str:
    """Return the outcome of an answer and the reasons; step by step where the record has an explanation."""
    explanation = record.explanation or Explanation()
    steps = enumerate(explanation.steps, 1)
    sections = (
        ("", [f"- {note}" for note in explanation.notes]),
        ("Steps\n", [f"{number}. `{step.action}`: {'; '.join(_of_step(step))}" for number, step in steps]),
        ("Goals\n", [f"- {_MARK[goal.satisfied]} {goal.kind} `{goal.goal}`" for goal in explanation.goals]),
        ("Temporal goal\n", [f"- {_part(part, i)}" for i, part in enumerate(explanation.parts)]),
    )
    written = ["\n".join(filter(None, [title, *lines])) for title, lines in sections if lines]
    return "\n\n".join([f"**{_headline(record)}**", *written])


def _headline(record: Record) -> str:
    verdict, came_to = record.verdict, outcome_of(record)
    if came_to is AnswerOutcome.EXCLUDED:
        return f"Excluded: {verdict.excluded}"
    label = label_of(came_to.value)
    if came_to is AnswerOutcome.NOT_ANSWERED:
        return f"{label}: {record.unanswered}"
    if verdict.error is None or came_to is AnswerOutcome.SUCCESS:
        return label
    return f"{label}: {verdict.error.detail}"


def _of_step(step: StepReport) -> Iterator[str]:
    yield f"{label_of(step.outcome).lower()}, {step.reason}" if step.reason else step.outcome
    if step.earlier:
        yield step.earlier
    for sign, facts in (("+", step.added), ("-", step.removed)):
        yield from (f"{sign} `{fact}`" for fact in facts)
    if step.hidden_changes:
        yield f"{step.hidden_changes} more change{'' if step.hidden_changes == 1 else 's'}, not shown"


def _part(part: PartReport, number: int) -> str:
    if part.met_after is not None:
        return f"✓ `{part.part}`, {part.when}"
    never = "never after that" if number else "never"
    lacking = f", {never}: {', '.join([f'`{text}`' for text in part.missing])}" if part.missing else ""
    return f"✗ `{part.part}`{lacking}"


@metric(name="paper", scores="unreduced")
def paper_metrics(ability: str) -> Metric:
    """The columns of the paper's tables, as shares: the rates of ``summary.json``, without those of nothing.

    They are sums over sums of all tasks. Of several answers to a task the mean counts, or the one that says
    what most of them say, as in ``eai run --epochs``. Where the form of all answers decides how each is read,
    they are read once more together.
    """

    def pooled(scores: list[SampleScore]) -> Value:
        asked = Ability.from_name(ability)
        ordered = sorted(scores, key=lambda score: int(_metadata(score)["epoch"]))
        by_task = group_pairs((str(score.sample_id), score) for score in ordered).values()
        averaged = declaration_of(asked).combine_epochs
        if averaged is None:
            verdicts = _verdicts([_chosen(of_task, asked) for of_task in by_task])
        else:
            verdicts = [averaged([_verdict(score) for score in of_task]) for of_task in by_task]
        shares = {name: rate.share for name, rate in summarise(verdicts, asked).items()}
        return shares if scores else dict.fromkeys(shares, nan)

    return pooled


def _register(ability: Ability) -> Callable[..., Scorer]:
    """Register the scorer of an ability, which has the ability's name and columns."""

    @scorer(metrics=[paper_metrics(ability.value), accuracy(), stderr()], name=ability.value)
    def verdict_scorer(
        benchmark: str, protocol: str, planner: str, errata: str = ErrataChoice.CURRENT.value
    ) -> Scorer:
        """Scores an answer with the pure function of the library.

        Args:
            benchmark: what `find_benchmark` finds the benchmark by.
            protocol: the rules for scoring.
            planner: which planner judges operators.
            errata: whether what is wrong in the data is corrected.
        """

        async def score(state: TaskState, target: Target) -> Score:
            suite = _suite(find_benchmark(benchmark), ability, protocol, planner, errata)
            return make_score(_record_of(state, suite), state.epoch, answered=bool(state.output.choices))

        return score

    return verdict_scorer


EXPERIMENT = "experiment"
"""The field of a sample's metadata, and of a record, that has the experiment it is of."""

SCORERS = {ability: _register(ability) for ability in find_abilities()}
"""The scorers by ability; the score of a sample has the ability's name."""


def _record_of(state: TaskState, suite: Suite) -> Record:
    model, task_id = to_file_name(str(state.model)), str(state.sample_id)
    if state.output.choices:
        text = episode_text(state) if declaration_of(suite.ability).takes_turns else state.output.completion
        answer = Response(task_id, text)
    else:  # the request failed, and Inspect scores all the same
        answer = Response(task_id, "", unanswered="the request failed")
    record = next(Scoring().records(suite, model, [answer], explanations=answer.unanswered is None))
    return apply_experiment(record, suite.over([state.input_text]), state.metadata, state.epoch)


def _with_rules(stated: Experiment, record: Record) -> Experiment:
    """Return the experiment of a log with the harness and the rules of an episode, which decide its verdict.

    The log may state further limits, such as one of tokens, that an episode does not name.
    """
    own = declaration_of(record.ability).read_experiment(record.response) or record.experiment or Experiment()
    in_episode, in_log = (
        {*(rules or "").split(RULES_SEPARATOR)} - {""} for rules in (own.rules, stated.rules)
    )
    rules = stated.rules if in_episode <= in_log else own.rules
    return replace(stated, harness=own.harness or stated.harness, rules=rules)


def apply_experiment(record: Record, suite: Suite, about: Mapping[str, Any], epoch: int) -> Record:
    """Return the record of an answer in a log as its experiment makes it.

    Attempts are carried out again, and what the question stated is judged again.

    Args:
        record: the record of the last answer, as if it were the answer to a plain question.
        suite: the suite, as it reads the answers.
        about: the metadata of the sample.
        epoch: the epoch of the sample.
    """
    written = about.get(EXPERIMENT)
    if written is None:
        return record
    stated = experiment_from_json(written) or Experiment()
    experiment, task_id = _with_rules(stated, record), record.task_id
    if record.unanswered is not None:
        return replace(record, experiment=experiment)
    options = AttemptOptions.from_experiment(experiment)
    if options is not None:
        attempts = replay(suite, options, task_id, about[ANSWERS], epoch)
        record = make_trial_record(suite, options, record.model, task_id, attempts)
    return summarized(replace(record, experiment=experiment), suite, about)


LoggedSamples: TypeAlias = Mapping[str, tuple[Mapping[str, Any], int, str]]
"""By task, the metadata, the epoch and the question of the sample in a log whose answer counts."""


def make_logged_record(
    suite: Suite, experiment: Mapping[str, Any], samples: LoggedSamples, record: Record
) -> Record:
    """Return the record of an answer in the log of an experiment.

    Args:
        suite: the suite.
        experiment: the experiment, as samples have it.
        samples: the samples.
        record: the record as if the answer were to a plain question.
    """
    about, epoch, question = samples.get(record.task_id, ({EXPERIMENT: experiment}, 1, ""))
    found = apply_experiment(record, suite.over([question]), about, epoch)
    return found.drop_explanations() if record.explanation is None else found


def make_score(record: Record, epoch: int, *, answered: bool) -> Score:
    """A record as the score of a sample; what is excluded is unscored, for its reason."""
    came_to = outcome_of(record)
    about = record_to_json(record.drop_explanations())
    score = Score.unscored(
        reason=record.verdict.excluded,
        answer=str(about.pop("response")),
        explanation=explain_record(record),
        metadata={"epoch": epoch, "answered": answered, "explorer": explorer_address(record), **about},
    )
    if came_to is not AnswerOutcome.EXCLUDED:
        score.value = CORRECT if came_to is AnswerOutcome.SUCCESS else INCORRECT
    return score


@cache
def _suite(benchmark: Benchmark, ability: Ability, protocol: str, planner: str, errata: str) -> Suite:
    source = Source(planner=planner_choice(planner), errata=errata_choice(errata))
    return open_suite(benchmark, ability, Protocol.from_name(protocol), source=source)


def _metadata(score: SampleScore) -> dict[str, Any]:
    return score.score.metadata or {}


def _answered(scores: Iterable[SampleScore]) -> list[SampleScore]:
    return [score for score in scores if _metadata(score)["answered"]]


def _chosen(scores: Sequence[SampleScore], ability: Ability) -> SampleScore:
    """Of the scores of one task, one epoch after the other, that of the answer that counts."""
    answered = _answered(scores) or scores
    return answered[majority_index([score.score.answer or "" for score in answered], ability)]


def _verdicts(scores: Sequence[SampleScore]) -> list[Verdict]:
    """The verdicts on the answers that count, each read as it is together with the others.

    Those of an experiment stand as they are: each was read before the next was asked for.
    """
    texts = {str(score.sample_id): score.score.answer or "" for score in _answered(scores)}
    verdicts = {str(score.sample_id): _verdict(score) for score in scores}
    if texts and not any(_metadata(score).get("attempts") for score in scores):
        suite = _suite_of(scores[0])
        together = suite.over(list(texts.values()))
        if together is not suite:
            verdicts |= {task_id: together.score(task_id, text) for task_id, text in texts.items()}
    return list(verdicts.values())


def _verdict(score: SampleScore) -> Verdict:
    return record_from_json(_metadata(score)).verdict


def _suite_of(score: SampleScore) -> Suite:
    """The suite that a score is of; no planner is asked where answers are read together."""
    benchmark, about = (score.sample_metadata or {})["domain"], _metadata(score)
    errata = ErrataChoice.CURRENT if about.get("errata") else ErrataChoice.NONE
    rules = (about["protocol"], PlannerChoice.NONE.value, errata.value)
    return _suite(find_benchmark(benchmark), Ability.from_name(about["ability"]), *rules)
