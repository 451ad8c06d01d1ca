"""An ability is one value: what is asked, how answers are read and judged, and how verdicts are counted.

The four of the paper are values of the same kind as any other. A distribution registers one, an
`AbilityDeclaration`, by an entry point of the group ``eai.abilities`` whose name is the ability's.

Plans and subgoals share their measures (the paper's tables "trajectory evaluation" and "goal satisfaction").
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeAlias, TypeVar

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import FOUR, Ability, registered_abilities
from eai.abilities.verdict import NOTHING, Confusion, PlanVerdict, Shares, Verdict, of_all
from eai.base.errors import InputError
from eai.tasks.share import Share
from eai.tasks.task import GoalKind
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.answer_schema import Schema
    from eai.abilities.notation.goals import GoalNotation
    from eai.abilities.notation.plans import PlanNotation
    from eai.abilities.notation.subgoals import SubgoalNotation
    from eai.abilities.scorer import Scorer
    from eai.abilities.task_features import TaskFeatures
    from eai.pddl.planning import PddlPlanner
    from eai.tasks.task import Task
    from eai.tasks.wording import Wording
    from eai.world.domain import Domain

V = TypeVar("V", bound=Verdict)


class AnswerOutcome(str, Enum):
    """The outcome of one answer, or of the lack of one; those that are no error of the model's come first."""

    EXCLUDED = "excluded"
    NOT_ANSWERED = "not_answered"
    SUCCESS = "success"
    PARTLY_RIGHT = "partly_right"
    """Goals or operators of which some are right."""
    GOAL_MISSED = "goal_missed"
    """The plan ran, or the goals or operators could be read, but nothing came of it."""
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
    """A column of an ability's tables, or of a report's.

    Attributes:
        metric: the name of the metric.
        group: the heading above it and its neighbours.
        label: its own heading.
        more_is_better: whether the largest number is the best, which then is printed in bold.
        ability: whose metric it shows, in tables of several; None for the average over all abilities.
    """

    metric: str
    group: str
    label: str
    more_is_better: bool = True
    ability: Ability | None = None


@dataclass(frozen=True, slots=True)
class AskedWorld:
    """The world of a benchmark as abilities see it: its declaration, and how its answers are written.

    Attributes:
        domain: the declaration.
        plans: how plans are written.
        goals: how goals are stated.
        subgoals: how subgoals are written; None for formulas with the declared names.
        subgoal_domain: makes the world in which subgoals are carried out.
        make_planner: makes the planner of operators, of which None says that none is to be asked.
        wording: how prompts of an ability name things.
        observed: how observations do.
        benchmark: the benchmark, for abilities that know what that is.
    """

    domain: Domain
    plans: PlanNotation
    goals: GoalNotation
    subgoals: SubgoalNotation | None
    subgoal_domain: Callable[[], Domain]
    make_planner: Callable[[], PddlPlanner | None]
    wording: Callable[[Ability], Wording]
    observed: Callable[[], Wording]
    benchmark: object = None


Posed: TypeAlias = tuple[str | Mapping[str, str], str]
"""A question about a task, or the values of places in the template of the ability's name; and a right answer
to it, which built-in models give."""


class OwnTasks(NamedTuple):
    """The tasks of a file that an ability is asked of, instead of a benchmark's.

    Attributes:
        name: what records call them, in the place of a domain.
        tasks: by id, in order.
        sha256: digest of the file.
    """

    name: str
    tasks: Mapping[str, Any]
    sha256: str


Pose: TypeAlias = Callable[[AskedWorld, Any], Posed]
"""Asks of a task in a world."""

Form: TypeAlias = "Callable[[Sequence[str] | None], Schema | None]"
"""The form of an answer in which objects go by these words, or by any."""


@dataclass(frozen=True, slots=True)
class Asked:
    """How an ability is asked: one question and one answer a task. All parts are pure functions.

    Of several answers to a task one may count that means what most do. Prose around JSON, white space and the
    order of keys make no difference then, unless the last attributes say otherwise.

    Attributes:
        scorers: from a world to what makes the scorer of a task, which reads answers and judges them.
        pose: asks of a task; None where questions are published or rendered from the templates of the
            ability's name, and right answers are the data set's.
        pictures: what is shown before a question that is posed, each with its media type.
        form: what objects of a task are called in answers, and the form of these; None where that is unknown.
        open_file: opens files of tasks of its own; None from one that is none.
        features: what a task of its own is like.
        written_by: the command that writes tasks of its own; empty where it is asked of a benchmark's tasks.
        of_operators: whether it is asked of the tasks of published operators, instead of the benchmark's own.
        keys_in_order: whether the keys of objects mean something by their order, as the steps of plans do.
        lists_are_sets: whether the order of lists means nothing; that of texts in a list does all the same.
        bare: how an answer begins that is no JSON; empty where it may be any text, None where it is none.
    """

    scorers: Callable[[AskedWorld], Callable[[Any], Scorer]]
    pose: Pose | None = None
    pictures: Callable[[AskedWorld, Any], Sequence[tuple[str, bytes]]] | None = None
    form: Callable[[AskedWorld, Task | None], tuple[Sequence[str], Form]] | None = None
    open_file: Callable[[Path], OwnTasks | None] | None = None
    features: Callable[[Any], TaskFeatures] | None = None
    written_by: str = ""
    of_operators: bool = False
    keys_in_order: bool = False
    lists_are_sets: bool = False
    bare: str | None = ""


@dataclass(frozen=True, slots=True)
class TakesTurns(Asked):
    """How an ability is asked whose answers are episodes: the question of a game, and commands in turns.

    Attributes:
        made_by: reads from an episode its harness and the rules of its game; None if the episode is empty or
            unreadable, and so fails by any rules.
    """

    made_by: Callable[[str], Experiment | None] = field(kw_only=True)


@dataclass(frozen=True, slots=True)
class AbilityDeclaration(Generic[V]):
    """An ability: how it is asked, and how records, metrics and tables know it.

    Attributes:
        ability: its name.
        asked: how it is asked; `TakesTurns` if its answers are episodes of games.
        title: its name for readers.
        short: its name where there is little room.
        verdict: the class of its verdicts, whose `merit` says what `eai.Reward` pays for.
        contributions: what an answer adds to each metric; all verdicts have the same metrics in one order.
        outcome: what an answer that is not excluded came to.
        columns: the columns of its tables, from left to right.
        terminal: the metrics that a terminal shows.
        main: the metrics of the overview, the paper's among them, each with its heading there.
        averaged: the metrics whose mean is its part in the paper's average over all abilities.
        instead: by a metric of the paper, the one that ranks and is averaged in its place where it is known.
        yes_no: the metrics to which every answer contributes a yes or a no.
        of_epochs: the verdicts on several answers to a task as one that adds their means; None where one
            answer counts for all, which says what most of them say.
        void: the metrics of which a run has nothing at all, as this one of its verdicts says.
        alike: whether two verdicts on tasks of one id are on the same task; always by default.
    """

    ability: Ability
    asked: Asked
    title: str
    short: str
    verdict: type[V]
    contributions: Callable[[V], Shares]
    outcome: Callable[[V], AnswerOutcome]
    columns: tuple[MetricColumn, ...]
    terminal: tuple[str, ...]
    main: Mapping[str, str]
    averaged: tuple[str, ...]
    instead: Mapping[str, str] = field(default_factory=dict)
    yes_no: frozenset[str] = frozenset()
    of_epochs: Callable[[Sequence[V]], V] | None = None
    void: Callable[[V], Collection[str]] = lambda verdict: ()
    alike: Callable[[V, V], bool] = lambda one, other: True

    @property
    def takes_turns(self) -> bool:
        """Whether its answers are episodes of games."""
        return isinstance(self.asked, TakesTurns)

    def made_by(self, answer: str) -> Experiment | None:
        """Return the harness and rules of an episode, and no choices for an answer that is not one.

        None if the episode is empty or unreadable, and so fails by any rules.
        """
        return self.asked.made_by(answer) if isinstance(self.asked, TakesTurns) else Experiment()

    @property
    def has_plans(self) -> bool:
        """Whether its answers are carried out."""
        return issubclass(self.verdict, PlanVerdict)


@cache
def declaration_of(ability: Ability) -> AbilityDeclaration[Any]:
    """The ability that is registered under a name.

    Raises:
        InputError: there is none, or what is registered is none.
    """
    point = registered_abilities().get(ability)
    if point is None:
        raise InputError(f"the ability {ability} is not installed")
    value = point.load()
    if not isinstance(value, AbilityDeclaration) or value.ability is not ability:
        raise InputError(f"{point.value}: expected the AbilityDeclaration of {ability}, found {value!r:.100}")
    return value


def the_four() -> Mapping[Ability, AbilityDeclaration[Any]]:
    """The paper's four abilities, in its order."""
    return {ability: declaration_of(ability) for ability in FOUR}


def error_outcome(verdict: Verdict) -> AnswerOutcome | None:
    """The error that ended an answer as an outcome, or None if none did."""
    return None if verdict.error is None else AnswerOutcome(verdict.error.kind.value)


def counts_outcome(counts: Confusion, *, enough: bool = True) -> AnswerOutcome:
    """The outcome of an answer whose parts are right or wrong; ``enough``: whether all right will do."""
    if enough and not counts.false_positives and counts.false_negatives <= 0:
        return AnswerOutcome.SUCCESS
    return AnswerOutcome.PARTLY_RIGHT if counts.true_positives else AnswerOutcome.GOAL_MISSED


def label_of(name: str) -> str:
    """A metric, a kind of error or a category for readers."""
    return name.replace("_", " ").replace(".", " ").capitalize()


def score_columns(parts: Sequence[str]) -> tuple[MetricColumn, ...]:
    """Precision, recall and F1 of each part."""
    measures = (("precision", "P"), ("recall", "R"), ("f1", "F1"))
    return tuple(
        MetricColumn(f"{part}.{measure}", label_of(part), label)
        for part in parts
        for measure, label in measures
    )


SUCCESS, GRAMMAR, RUNTIME, SATISFIED = "Success", "Grammar errors", "Runtime errors", "Satisfied goals"
PLANNER = "Planner"
"""The groups of columns; the last is that of planner success."""

OVERALL = "overall"
"""The prefix of the rates over all categories of predicates."""

KINDS = tuple(kind.value for kind in GoalKind)
GOAL_METRICS = (*(f"{kind}_goal" for kind in KINDS), "total_goal")
PARTIAL = "partial_success"
"""The metric of conditions met (`eai.tasks.goal_test`): the mean of the shares of all answers."""

GOAL_COLUMNS = (
    *(MetricColumn(metric, SATISFIED, label_of(metric.removesuffix("_goal"))) for metric in GOAL_METRICS),
    MetricColumn(PARTIAL, SATISFIED, "Partial success"),
)
"""The columns of goals that plans reach."""

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
"""The columns of the paper's tables."""

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
"""The kinds of error that make an action impossible, by their names."""

P = TypeVar("P", bound=PlanVerdict)


def on_trajectories(
    ability: Ability,
    asked: Asked,
    title: str,
    short: str,
    verdict: type[P],
    contributions: Callable[[P], Shares],
) -> AbilityDeclaration[P]:
    """The declaration of an ability whose answers are executed."""
    main = {"task_success": "Task", "execution_success": "Execution"}
    return AbilityDeclaration(
        ability=ability,
        asked=asked,
        title=title,
        short=short,
        verdict=verdict,
        contributions=contributions,
        outcome=plan_outcome,
        columns=COLUMNS,
        terminal=tuple(column.metric for column in COLUMNS),
        main=main,
        averaged=("task_success",),
        yes_no=frozenset(main),
    )


def times(verdict: PlanVerdict, kind: FaultKind) -> int:
    """How often a kind of error that ends a plan counts."""
    if verdict.counted is not None:
        return verdict.counted.errors.get(kind, 0)
    return int(verdict.error is not None and verdict.error.kind is kind)


def times_additional(verdict: PlanVerdict) -> int:
    """How often additional steps count: once an answer, unless the verdict says otherwise."""
    if verdict.counted is not None:
        return times(verdict, FaultKind.ADDITIONAL_STEP)
    return int(bool(verdict.additional_steps))


def goal_shares(verdict: PlanVerdict) -> Shares:
    """Return the contributions of one answer to the rates of goals; nothing if its goals are not known."""
    goals = verdict.goals if verdict.counted is None else verdict.counted.goals
    known: tuple[Share, ...] = (NOTHING,) * len(KINDS) if goals is None else goals
    whole = Share(sum(share.numerator for share in known), sum(share.denominator for share in known))
    partial = verdict.partial
    met = NOTHING if partial is None else of_all(partial.numerator / partial.denominator)
    return {**dict(zip(GOAL_METRICS, (*known, whole), strict=True)), PARTIAL: met}


def plan_outcome(verdict: PlanVerdict) -> AnswerOutcome:
    """The outcome of a plan."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return error_outcome(verdict) or AnswerOutcome.GOAL_MISSED
