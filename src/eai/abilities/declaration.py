"""Declarations of abilities (kinds of questions): their scorers, metrics and columns of tables.

One `AbilityDeclaration` declares one ability. A Python distribution registers it under the ability's name, as
an entry point of the group ``eai.abilities``. The four abilities of the paper are registered in this way,
too.

The abilities whose answers are plans or subgoals have the same metrics: those in the paper's tables
"trajectory evaluation" and "goal satisfaction".
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, Ability, find_ability_entry_points
from eai.abilities.verdict import (
    EMPTY_SHARE,
    ConfusionCounts,
    PlanVerdict,
    ShareByMetric,
    Verdict,
    make_rate_contribution_of_answer,
)
from eai.base.errors import InputError
from eai.tasks.share import Share
from eai.tasks.task import GoalKind
from eai.world.fault import NOT_EXECUTED, FaultKind

if TYPE_CHECKING:
    from eai.abilities.answer_schema import Schema
    from eai.abilities.notation.notation import Notation
    from eai.abilities.notation.subgoals import SubgoalNotation
    from eai.abilities.scorer import Scorer
    from eai.abilities.task_features import TaskFeatures
    from eai.pddl.planning import PddlPlanner
    from eai.tasks.source import TaskSet
    from eai.tasks.task import Task
    from eai.tasks.wording import PromptAndAnswerWording
    from eai.world.domain import Domain

V = TypeVar("V", bound=Verdict)


class AnswerOutcome(str, Enum):
    """The outcome of one answer, or of a missing answer.

    `EXCLUDED` to `GOAL_MISSED` are outcomes without an error. All other outcomes are kinds of errors.
    """

    EXCLUDED = "excluded"
    NOT_ANSWERED = "not_answered"
    SUCCESS = "success"
    PARTLY_RIGHT = "partly_right"
    """Some goals or operators in the answer are right; others are wrong or missing."""
    GOAL_MISSED = "goal_missed"
    """A plan ran to its end but missed the goal. For answers without a plan: no goal or operator is right."""
    PARSING = FaultKind.PARSING.value
    HALLUCINATION = FaultKind.HALLUCINATION.value
    ARGUMENT_NUMBER = FaultKind.ARGUMENT_NUMBER.value
    AFFORDANCE = FaultKind.AFFORDANCE.value
    MISSING_STEP = FaultKind.MISSING_STEP.value
    WRONG_ORDER = FaultKind.WRONG_ORDER.value
    ADDITIONAL_STEP = FaultKind.ADDITIONAL_STEP.value
    UNCATEGORISED = FaultKind.UNCATEGORISED.value
    SLIP = FaultKind.SLIP.value


@dataclass(frozen=True, slots=True)
class MetricColumn:
    """A column in the tables of an ability (kind of question) or a report.

    Attributes:
        metric: name of the metric in this column.
        group: heading above this column and its neighbours.
        label: heading of this column.
        more_is_better: whether the largest number is the best. Tables print the best number in bold.
        ability: ability of the metric in tables of several abilities; None for the average over all
            abilities.
    """

    metric: str
    group: str
    label: str
    more_is_better: bool = True
    ability: Ability | None = None


@dataclass(frozen=True, slots=True)
class DomainAndNotation:
    """The parts of a benchmark that abilities need: its declared domain, its notation of answers, and more.

    Attributes:
        domain: the declared domain.
        notation: how answers are written and things are named.
        subgoal_notation: returns the notation of subgoals.
        make_planner: returns the planner that tests operators, or None if operators are not tested.
        wording: returns the names of objects and predicates in the prompts of an ability.
        observation_wording: returns the names of objects and predicates in observations.
        benchmark: the benchmark, for abilities that need its own methods.
    """

    domain: Domain
    notation: Notation
    subgoal_notation: Callable[[], SubgoalNotation]
    make_planner: Callable[[], PddlPlanner | None]
    wording: Callable[[Ability], PromptAndAnswerWording]
    observation_wording: Callable[[], PromptAndAnswerWording]
    benchmark: object = None


QuestionAndAnswer: TypeAlias = tuple[str | Mapping[str, str], str]
"""A pair: the question about a task, and a right answer, which built-in models give.

The question is a text, or a mapping from the placeholders of the ability's template to texts.
"""


QuestionMaker: TypeAlias = Callable[[DomainAndNotation, Any], QuestionAndAnswer]
"""Function that makes the question and a right answer, given a benchmark's declarations and a task."""

SchemaMaker: TypeAlias = "Callable[[Sequence[str] | None], Schema | None]"
"""Function that makes the JSON schema of an answer.

It takes the words that may name objects in the answer; None if any text may name an object.
"""


@dataclass(frozen=True, slots=True)
class SingleQuestionInteraction:
    """The exchange with a model: one question and one answer for each task. All functions in it are pure.

    If a model answers a task several times, its most frequent answer may count. Two answers are the same if
    they differ only in prose around JSON, white space and the order of keys, unless `keys_in_order`,
    `lists_are_sets` or `plain_text_prefix` say otherwise.

    Attributes:
        scorers: takes a benchmark's domain and notation, and returns a function that makes the scorer of a
            task.
        make_question: makes the question about a task. None if questions are published, or are rendered from
            the template with the ability's name. The data set then has the right answers.
        pictures: returns the pictures before a question, each with its media type.
        answer_form: returns the words for objects in answers to a task, and the function that makes the JSON
            schema of an answer; None if answers have no schema.
        open_file: opens a file with tasks that only this ability has. It returns the name of their domain and
            the tasks; None for a file of another kind.
        features: returns the features of a task that only this ability has.
        task_command: command that writes the ability's own tasks; empty if the ability uses a benchmark's
            tasks.
        uses_operator_tasks: whether the ability uses the published tasks about operators instead of the
            benchmark's tasks.
        keys_in_order: whether the order of keys in objects has a meaning, as in steps of plans.
        lists_are_sets: whether the order of items in a list has no meaning, except in lists of texts.
        plain_text_prefix: beginning of an answer that is not JSON; empty for any text, None if an answer must
            be JSON.
    """

    scorers: Callable[[DomainAndNotation], Callable[[Any], Scorer]]
    make_question: QuestionMaker | None = None
    pictures: Callable[[DomainAndNotation, Any], Sequence[tuple[str, bytes]]] | None = None
    answer_form: Callable[[DomainAndNotation, Task | None], tuple[Sequence[str], SchemaMaker]] | None = None
    open_file: Callable[[Path], tuple[str, TaskSet[Any]] | None] | None = None
    features: Callable[[Any], TaskFeatures] | None = None
    task_command: str = ""
    uses_operator_tasks: bool = False
    keys_in_order: bool = False
    lists_are_sets: bool = False
    plain_text_prefix: str | None = ""


@dataclass(frozen=True, slots=True)
class MultiTurnInteraction(SingleQuestionInteraction):
    """The exchange with a model that plays a game: a first question, then the model's commands in turns.

    The answer of the model is the complete episode.

    Attributes:
        read_episode_settings: returns the harness (the program around the model) and the rules of the game
            from an episode; None for an empty or unreadable episode, which fails under any rules.
    """

    read_episode_settings: Callable[[str], Experiment | None] = field(kw_only=True)


@dataclass(frozen=True, slots=True)
class AbilityDeclaration(Generic[V]):
    """The declaration of an ability (kind of question): the exchange with a model, and its tables.

    Attributes:
        ability: name of the ability.
        interaction: the exchange with a model; a `MultiTurnInteraction` if answers are episodes.
        title: name of the ability for readers.
        short_title: name of the ability for narrow columns.
        verdict: class of the verdicts. `eai.Reward` uses its method `compute_reward_inputs`.
        contributions: takes a verdict and returns what the answer adds to each metric. All verdicts have the
            same metrics in the same order.
        outcome: returns the outcome of an answer, given its verdict. The verdict must not be excluded.
        columns: columns of the ability's tables, from left to right.
        terminal_metrics: metrics in the tables that are printed in a terminal.
        overview_headings: mapping from metrics to their headings in the overview of all abilities, the
            paper's metrics included.
        averaged_metrics: metrics whose mean enters the paper's average over all abilities.
        replacements: mapping from some of the paper's metrics to metrics that replace them in rankings and
            averages, if an answer has these.
        yes_no_metrics: metrics to which each answer contributes yes or no.
        combine_epochs: combines the verdicts on several answers to a task into a verdict with their mean
            metrics. None if the most frequent answer counts for all answers.
        missing_metrics: takes any verdict of a run and returns the metrics for which no answer of the run has
            a value.
        is_same_task: whether two verdicts with the same task id are on the same task; by default always True.
    """

    ability: Ability
    interaction: SingleQuestionInteraction
    title: str
    short_title: str
    verdict: type[V]
    contributions: Callable[[V], ShareByMetric]
    outcome: Callable[[V], AnswerOutcome]
    columns: tuple[MetricColumn, ...]
    terminal_metrics: tuple[str, ...]
    overview_headings: Mapping[str, str]
    averaged_metrics: tuple[str, ...]
    replacements: Mapping[str, str] = field(default_factory=dict)
    yes_no_metrics: frozenset[str] = frozenset()
    combine_epochs: Callable[[Sequence[V]], V] | None = None
    missing_metrics: Callable[[V], Collection[str]] = lambda verdict: ()
    is_same_task: Callable[[V, V], bool] = lambda one, other: True

    @property
    def takes_turns(self) -> bool:
        """Whether an answer is an episode of a game: the model gives commands in several turns."""
        return isinstance(self.interaction, MultiTurnInteraction)

    def read_episode_settings(self, answer: str) -> Experiment | None:
        """Return the settings under which a model gave an answer over several turns (an episode).

        The settings are the program around the model (harness) and the rules of the turns. For an ability
        whose answers have one turn, the `Experiment` has no settings. Return None if the episode is empty or
        unreadable.
        """
        if isinstance(self.interaction, MultiTurnInteraction):
            return self.interaction.read_episode_settings(answer)
        return Experiment()

    @property
    def answers_are_plans(self) -> bool:
        """Whether answers are executed as plans."""
        return issubclass(self.verdict, PlanVerdict)


@cache
def get_declaration(ability: Ability) -> AbilityDeclaration[Any]:
    """Return the declaration of an installed ability (kind of question).

    Raises:
        InputError: the ability is not installed, or its entry point is not a declaration of the ability.
    """
    point = find_ability_entry_points().get(ability)
    if point is None:
        raise InputError(f"the ability {ability} is not installed: install the package that provides it")
    value = point.load()
    if not isinstance(value, AbilityDeclaration) or value.ability is not ability:
        raise InputError(
            f"entry point {point.value}: expected the AbilityDeclaration of {ability}, found {value!r:.100}; "
            "install another release of the package that provides it"
        )
    return value


def load_declarations_of_paper_abilities() -> Mapping[Ability, AbilityDeclaration[Any]]:
    """Return a mapping from the paper's four abilities to their declarations, in the paper's order."""
    return {ability: get_declaration(ability) for ability in PAPER_ABILITIES}


def find_error_outcome(verdict: Verdict) -> AnswerOutcome | None:
    """Return the outcome of an answer with an error in its verdict, or None if the verdict has no error."""
    return None if verdict.error is None else AnswerOutcome(verdict.error.kind.value)


def classify_answer_by_counts(counts: ConfusionCounts, *, can_be_success: bool = True) -> AnswerOutcome:
    """Return the outcome of an answer whose parts, such as goals, are judged separately.

    Args:
        counts: numbers of right, wrong and missed parts.
        can_be_success: whether an answer with all parts and no wrong part is a success. If False, the answer
            never counts as a success here.
    """
    if can_be_success and not counts.false_positives and counts.false_negatives <= 0:
        return AnswerOutcome.SUCCESS
    return AnswerOutcome.PARTLY_RIGHT if counts.true_positives else AnswerOutcome.GOAL_MISSED


def get_display_name(name: str) -> str:
    """Return the name of a metric, an error or a category as readers see it."""
    return name.replace("_", " ").replace(".", " ").capitalize()


def make_score_columns(answer_parts: Sequence[str]) -> tuple[MetricColumn, ...]:
    """Return table columns for precision, recall and F1 of parts of answers, such as preconditions."""
    measures = (("precision", "P"), ("recall", "R"), ("f1", "F1"))
    return tuple(
        MetricColumn(f"{part}.{measure}", get_display_name(part), label)
        for part in answer_parts
        for measure, label in measures
    )


SUCCESS, GRAMMAR, RUNTIME, SATISFIED = "Success", "Grammar errors", "Runtime errors", "Satisfied goals"
PLANNER = "Planner"
"""Heading of the table columns that say whether a planner finds plans with a model's operators."""

OVERALL = "overall"
"""Prefix of the names of rates that count all categories of predicates."""

KINDS = tuple(kind.value for kind in GoalKind)
GOAL_METRICS = (*(f"{kind}_goal" for kind in KINDS), "total_goal")
PARTIAL = "partial_success"
"""Name of the metric of partial success: the mean share of the goals' conditions that are met."""

GOAL_COLUMNS = (
    *(
        MetricColumn(metric, SATISFIED, get_display_name(metric.removesuffix("_goal")))
        for metric in GOAL_METRICS
    ),
    MetricColumn(PARTIAL, SATISFIED, "Partial success"),
)
"""Columns of tables for the shares of goals that plans reach."""

COLUMNS = (
    MetricColumn("task_success", SUCCESS, "Task"),
    MetricColumn("execution_success", SUCCESS, "Execution"),
    MetricColumn("parsing", GRAMMAR, "Parsing", False),
    MetricColumn("hallucination", GRAMMAR, "Hallucination", False),
    MetricColumn("argument_number", GRAMMAR, "Arguments", False),
    MetricColumn("wrong_order", RUNTIME, "Wrong order", False),
    MetricColumn("missing_step", RUNTIME, "Missing step", False),
    MetricColumn("affordance", RUNTIME, "Affordance", False),
    MetricColumn("additional_step", RUNTIME, "Additional step", False),
    *GOAL_COLUMNS,
)
"""Columns of the paper's tables on plans and subgoals."""

ENDING_FAULTS = {
    kind.value: kind
    for kind in (
        FaultKind.PARSING,
        FaultKind.HALLUCINATION,
        FaultKind.ARGUMENT_NUMBER,
        FaultKind.WRONG_ORDER,
        FaultKind.MISSING_STEP,
        FaultKind.AFFORDANCE,
        FaultKind.UNCATEGORISED,
    )
}
"""Name of a metric -> the kind of error that it counts; only errors that end the execution of a plan."""

RUNTIME_FAULTS = {name: kind for name, kind in ENDING_FAULTS.items() if kind not in NOT_EXECUTED}
"""Name of a metric -> the kind of error that it counts; only errors of steps that cannot be executed."""

P = TypeVar("P", bound=PlanVerdict)


def declare_plan_ability(
    ability: Ability,
    interaction: SingleQuestionInteraction,
    title: str,
    short_title: str,
    verdict: type[P],
    compute_shares: Callable[[P], ShareByMetric],
) -> AbilityDeclaration[P]:
    """Return the declaration of an ability (kind of question) whose answers are executed as plans."""
    main = {"task_success": "Task", "execution_success": "Execution"}
    return AbilityDeclaration(
        ability=ability,
        interaction=interaction,
        title=title,
        short_title=short_title,
        verdict=verdict,
        contributions=compute_shares,
        outcome=classify_plan_outcome,
        columns=COLUMNS,
        terminal_metrics=tuple(column.metric for column in COLUMNS),
        overview_headings=main,
        averaged_metrics=("task_success",),
        yes_no_metrics=frozenset(main),
    )


def count_faults_for_summary(verdict: PlanVerdict, kind: FaultKind) -> int:
    """Return the number of errors of a kind that one answer adds to the sum over many answers.

    If the verdict has `SummaryCounts`, this is their number of errors of the kind. Otherwise it is 1 if an
    error of the kind ended the plan, else 0.
    """
    if verdict.counted is not None:
        return verdict.counted.errors.get(kind, 0)
    return int(verdict.error is not None and verdict.error.kind is kind)


def count_needless_steps_for_summary(verdict: PlanVerdict) -> int:
    """Return the number of additional (needless) steps that one answer adds to the sum over many answers.

    If the verdict has `SummaryCounts`, these hold the number. Otherwise the number is 1 if the answer has one
    or more additional steps, else 0.
    """
    if verdict.counted is not None:
        return count_faults_for_summary(verdict, FaultKind.ADDITIONAL_STEP)
    return int(bool(verdict.additional_steps))


def compute_reached_goal_shares(verdict: PlanVerdict) -> ShareByMetric:
    """Return for each metric of reached goals the numerator and the denominator that one answer adds.

    Both numbers are 0 if the verdict does not say which goals are reached.
    """
    goals = verdict.goals if verdict.counted is None else verdict.counted.goals
    shares: tuple[Share, ...] = (EMPTY_SHARE,) * len(KINDS) if goals is None else goals
    whole = Share(sum(share.numerator for share in shares), sum(share.denominator for share in shares))
    partial = verdict.partial
    met = (
        EMPTY_SHARE
        if partial is None
        else make_rate_contribution_of_answer(partial.numerator / partial.denominator)
    )
    return {**dict(zip(GOAL_METRICS, (*shares, whole), strict=True)), PARTIAL: met}


def classify_plan_outcome(verdict: PlanVerdict) -> AnswerOutcome:
    """Return the outcome of an answer that is executed as a plan."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return find_error_outcome(verdict) or AnswerOutcome.GOAL_MISSED
