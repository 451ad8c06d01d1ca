"""Lines of tidy tables (answers, steps, goals, atoms, clauses), and functions that group lines.

The first columns of every line name its run and task, so that any two tables can be joined. A value that is
unknown, or has no meaning for an ability, is None. `estimate_share_of_each_kind` counts answers by outcome,
errors by failed check, and wrong goals by reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from eai.abilities.protocol import Ability
from eai.abilities.verdict import EMPTY_SHARE, FULL_SHARE, ZERO_SHARE
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContribution
from eai.results.table import Estimate
from eai.tasks.share import Share


@dataclass(frozen=True, slots=True, kw_only=True)
class TidyTableLine:
    """The first columns of every line of a tidy table.

    Attributes:
        protocol: the rules for scoring.
        domain: name of the benchmark.
        ability: name of the ability.
        model: name of the model that answered.
        harness: program that let the model act, if known.
        effort: reasoning effort of the model; None for the provider's default.
        experiment: label of the run's studies (variations of its questions); None for a plain run.
        task: the data set's id of the task.
        name: name that near copies of the task share.
    """

    protocol: str
    domain: str
    ability: str
    model: str
    harness: str | None = None
    effort: str | None = None
    experiment: str | None = None
    task: str
    name: str

    @property
    def model_harness_and_effort(self) -> str:
        """Names of model, harness (program that lets it act) and effort, joined by commas, without None."""
        return ", ".join(filter(None, (self.model, self.harness, self.effort)))


@dataclass(frozen=True, slots=True, kw_only=True)
class AnswerTableLine(TidyTableLine):
    """One answer or missing answer, with the features of its task (`eai.benchmarks.features`).

    Attributes:
        outcome: outcome of the answer: ``success``, ``goal_missed``, a kind of error, ``excluded``, ...
        success: whether the answer counts as a success in the ability's tables; None if the ability has no
            success metric or the answer is excluded.
        executable: for plans and subgoals, whether all steps were executed.
        error_kind: kind of the error that ended the plan.
        error_check: name of the check that failed.
        error_step: number of the failed step or subgoal, from 0.
        error_objects: objects that the reason names, separated by spaces.
        additional_steps: for plans and subgoals, number of steps that were not needed.
        steps_tried: number of steps that were tried; None in records without explanations.
        state_met: for plans and subgoals, number of state goals reached, halves included.
        state_total: number of state goals.
        relation_met: number of relation goals reached, halves included.
        relation_total: number of relation goals.
        action_met: number of action goals reached, halves included.
        action_total: number of action goals.
        conditions_met: for plans and subgoals, number of goal conditions met (`eai.tasks.goal_test`).
        conditions: number of all goal conditions.
        hits: number of right goal conditions (goal interpretation) or right clauses of preconditions and
            effects (transition modeling) in the answer.
        extras: number of wrong goal conditions or clauses in the answer.
        misses: number of right goal conditions or clauses that the answer lacks.
        stated: in goal interpretation, number of goals in the answer, also of goals that scoring leaves out.
        ill_formed: in goal interpretation, number of stated goals that lack an argument or field.
        hallucinated: in goal interpretation, number of stated goals with unknown names.
        planner: in transition modeling, result of the planner with the answer's operators.
        task_categories: in transition modeling, categories of the task, separated by spaces.
        cut_off: whether a length limit cut the answer off; None if unknown.
        characters: length of the answer in characters.
        output_tokens: tokens of the answer; None if the run did not count them.
        cost: cost of the answer in dollars; None if unknown.
    """

    outcome: str
    success: bool | None
    executable: bool | None
    error_kind: str | None
    error_check: str | None
    error_step: int | None
    error_objects: str | None
    additional_steps: int | None
    steps_tried: int | None
    state_met: float | None
    state_total: float | None
    relation_met: float | None
    relation_total: float | None
    action_met: float | None
    action_total: float | None
    conditions_met: int | None
    conditions: int | None
    hits: int | None
    extras: int | None
    misses: int | None
    stated: int | None
    ill_formed: int | None
    hallucinated: int | None
    planner: str | None
    task_categories: str | None
    cut_off: bool | None
    characters: int
    output_tokens: int | None
    cost: float | None
    annotated_steps: int | None
    annotated_operators: int | None
    tool_steps: int | None
    goals: int | None
    state_goals: int | None
    relation_goals: int | None
    action_goals: int | None
    quantified_goals: int | None
    goal_options: int | None
    ground_goals: int | None
    ground_state_goals: int | None
    ground_relation_goals: int | None
    ground_action_goals: int | None
    goals_at_start: int | None
    objects: int | None
    object_categories: int | None
    initial_facts: int | None
    instruction_words: int | None
    containers: int | None
    hidden: int | None
    labels: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanStepTableLine(TidyTableLine):
    """One tried step of a plan, or of the execution of subgoals.

    Attributes:
        step: number of the step, from 0.
        operator: name of the action.
        objects: objects of the action, separated by spaces.
        outcome: ``executed``, the kind of error, or ``planned`` for a step that the planner found with the
            answer's operators (transition modeling).
        reason: the failed check in words.
    """

    step: int
    operator: str
    objects: str
    outcome: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskGoalTableLine(TidyTableLine):
    """One goal of a task, and whether an answer with a plan or subgoals reaches it.

    Attributes:
        goal: number of the goal, from 0.
        kind: ``state``, ``relation`` or ``action``.
        text: the goal as text.
        predicates: distinct predicates of the goal, or its actions, separated by spaces.
        satisfied: whether the goal is reached.
    """

    goal: int
    kind: str
    text: str
    predicates: str
    satisfied: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class InterpretedGoalTableLine(TidyTableLine):
    """One goal of an answer to goal interpretation, or one right goal that the answer lacks.

    Attributes:
        verdict: ``matched``, ``wrong`` or ``missing``.
        atom: the goal, as answers state it.
        predicate: predicate of the goal, or its action.
        positive: whether the goal should hold; False for a negated goal.
        reason: where a wrong goal comes from (`WrongGoalReason`), if known.
    """

    verdict: str
    atom: str
    predicate: str
    positive: bool
    reason: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatorClauseTableLine(TidyTableLine):
    """One clause of an operator in transition modeling, which an answer has or lacks.

    Attributes:
        operator: name of the operator.
        status: status of the operator: ``compared``, ``missing``, ``unreadable`` or ``hallucinated``.
        side: ``precondition`` or ``effect``.
        verdict: ``matched``, ``additional`` or ``missing``.
        clause: the clause as PDDL.
        predicates: predicates of the clause, separated by spaces.
        categories: categories of these predicates, separated by spaces.
    """

    operator: str
    status: str
    side: str
    verdict: str
    clause: str
    predicates: str
    categories: str


TABLES: Mapping[str, type[TidyTableLine]] = {
    "answers": AnswerTableLine,
    "steps": PlanStepTableLine,
    "goals": TaskGoalTableLine,
    "atoms": InterpretedGoalTableLine,
    "clauses": OperatorClauseTableLine,
}
"""Mapping from the name of each tidy table to the class of its lines."""


L = TypeVar("L", bound=TidyTableLine)

SUITE = ("protocol", "domain", "ability")
"""Names of the columns that name the suite of a row: protocol (scoring rules), benchmark and ability."""

MODEL = "model"
"""Name of the column with the names of models."""

ALL_MODELS = "all models"
"""Name that replaces the model in rows about the answers of all models together."""


AnswerScoreName: TypeAlias = Literal["score", "executable", "goals"]
"""Name of a score in `MEASURES`. Analyses show how the score of answers depends on features of tasks."""

WrongGoalReason: TypeAlias = Literal["unknown", "procedural", "initial", "final", "intermediate", "other"]
"""Reasons for a wrong stated goal; the first reason that fits counts.

- unknown: the benchmark does not have its predicate or action.
- procedural: it is an action that is a goal of no task.
- initial: it holds at the start.
- final: it holds at the end of the data set's own plan, but is no goal.
- intermediate: it holds at some time during that plan, but neither at the start nor at the end.
- other: no other reason fits.
"""


class SuiteKey(NamedTuple):
    """Identifies a suite, as in tables and file names: a protocol (rules), a benchmark and an ability."""

    protocol: str
    domain: str
    ability: str

    def __str__(self) -> str:
        return f"{self.domain} {Ability(self.ability).value.replace('_', ' ')}, {self.protocol}"

    @property
    def suite_name_for_file_names(self) -> str:
        """The protocol, benchmark and ability as part of a file name."""
        return f"{self.domain}-{self.ability}-{self.protocol}"


def group_by_suite(lines: Iterable[L]) -> dict[SuiteKey, list[L]]:
    """Return a mapping from each suite to its table lines, ordered by first occurrence."""
    return group_pairs((SuiteKey(line.protocol, line.domain, line.ability), line) for line in lines)


def group_by_model(lines: Sequence[L]) -> dict[str, list[L]]:
    """Return a mapping from each agent (model, harness and effort) to its table lines.

    If there are several agents, the lines of all agents together come first, under `ALL_MODELS`.
    """
    models = group_pairs((line.model_harness_and_effort, line) for line in lines)
    return models if len(models) < 2 else {ALL_MODELS: list(lines), **models}


def group_by_run(lines: Iterable[L]) -> Iterator[tuple[tuple[str, str, str, str], list[L]]]:
    """Yield protocol, domain, ability and model with the table lines that share them.

    As in `group_by_model`, harness and effort are a part of the model's name.
    """
    for suite, of_suite in group_by_suite(lines).items():
        for model, of_model in group_by_model(of_suite).items():
            yield (*suite, model), of_model


def compute_contribution_to_main_score(answer: AnswerTableLine) -> Share:
    """Return an answer's contribution to its ability's main score.

    The main score is success, or F1 if the ability has no success metric. Excluded answers add nothing.
    """
    if answer.success is not None:
        return Share(int(answer.success), 1)
    if answer.hits is None or answer.extras is None or answer.misses is None:
        return EMPTY_SHARE
    return Share(2 * answer.hits, 2 * answer.hits + answer.extras + answer.misses)


def compute_executed_share(answer: AnswerTableLine) -> Share:
    """Return 1 of 1 if the answer's plan or subgoals were executed without error, else 0 of 1.

    Return 0 of 0 for an answer that has neither.
    """
    return EMPTY_SHARE if answer.success is None or answer.executable is None else Share(answer.executable, 1)


def compute_share_of_reached_goals(answer: AnswerTableLine) -> Share:
    """Return how many goals a plan or subgoals reach, and out of how many; 0 of 0 for other answers."""
    if answer.success is None:
        return EMPTY_SHARE
    met = (answer.state_met, answer.relation_met, answer.action_met)
    total = (answer.state_total, answer.relation_total, answer.action_total)
    return Share(sum(count or 0 for count in met), sum(count or 0 for count in total))


def make_task_rate_contribution(line: TidyTableLine, share: Share) -> TaskRateContribution:
    """Return a contribution to a rate: the task of a table line, and the share (numerator, denominator)."""
    return TaskRateContribution(line.task, line.name, share)


MEASURES: Mapping[AnswerScoreName, Callable[[AnswerTableLine], Share]] = {
    "score": compute_contribution_to_main_score,
    "executable": compute_executed_share,
    "goals": compute_share_of_reached_goals,
}
"""Mapping from each score to the function that returns an answer's contribution to it."""


K = TypeVar("K")


def estimate_share_of_each_kind(
    lines: Sequence[TidyTableLine], kind_of_each_line: Sequence[K], requested_kinds: Iterable[K]
) -> Iterator[tuple[K, Estimate]]:
    """Yield for each kind, such as a kind of error, the share of lines that have this kind.

    Args:
        lines: the lines of a table, such as one for each answer.
        kind_of_each_line: the kind of each line, in the same order.
        requested_kinds: the kinds to yield, in order.
    """
    counted, uncounted = (
        [make_task_rate_contribution(line, share) for line in lines] for share in (FULL_SHARE, ZERO_SHARE)
    )
    for kind in requested_kinds:
        triples = zip(kind_of_each_line, counted, uncounted, strict=True)
        yield (
            kind,
            Estimate.from_task_rate_contributions(
                [case if line_kind == kind else other for line_kind, case, other in triples]
            ),
        )
