"""The lines of the tidy tables: an answer, a step, a goal, an atom, a clause; and lines by suite and model.

Every line begins with what it is a line of, so that any table can be joined with any other. A value that is
not known, or means nothing for an ability, is None. Shares of lines are by their kind: of answers by leaf, of
errors by check, of wrong goals by reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from eai.abilities.protocol import Ability
from eai.abilities.verdict import EMPTY_SHARE, FULL_SHARE, ZERO_SHARE
from eai.base.grouping import group_pairs
from eai.results.certainty import Case
from eai.results.table import Estimate
from eai.tasks.share import Share


@dataclass(frozen=True, slots=True, kw_only=True)
class TidyLine:
    """The columns that every line begins with.

    Attributes:
        protocol: the rules for scoring.
        domain: the benchmark's name.
        ability: which of the four.
        model: who answered.
        harness: in what it acted, where that is known.
        effort: how much it was to reason; None for the provider's default.
        experiment: the label of the studies that its run combines; None for a plain run.
        task: the data set's id of the task.
        name: what near copies of the task share.
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
    def agent(self) -> str:
        """The model with its harness and effort, as tables name it."""
        return ", ".join(filter(None, (self.model, self.harness, self.effort)))


@dataclass(frozen=True, slots=True, kw_only=True)
class AnswerLine(TidyLine):
    """One answer, or the lack of one, and what its task is like (`eai.benchmarks.features`).

    Attributes:
        outcome: what it came to: ``success``, ``goal_missed``, a kind of error, ``excluded``, ...
        success: whether it counts as a success in the ability's tables; None where there is no such thing,
            and of what is excluded.
        executable: plans and subgoals: whether all was carried out.
        error_kind: what ended it.
        error_check: which check failed.
        error_step: at which step or subgoal, from 0.
        error_objects: of which objects the reason speaks, with blanks between.
        additional_steps: plans and subgoals: how many steps were not needed.
        steps_tried: how many steps were tried; None in records without explanations.
        state_met: plans and subgoals: how many of the goals about states are reached, halves included.
        state_total: of how many.
        relation_met: the same of relations.
        relation_total: of how many.
        action_met: the same of actions.
        action_total: of how many.
        conditions_met: plans and subgoals: number of conditions met (`eai.tasks.goal_test`).
        conditions: number of all conditions.
        hits: goal interpretation: conditions that are stated; transition modeling: clauses, of preconditions
            and effects together, that are written.
        extras: those that are stated or written and wrong.
        misses: those that lack.
        stated: goal interpretation: how many goals the answer states, those left out included.
        ill_formed: how many of them lack a part.
        hallucinated: how many of them name what does not exist.
        planner: transition modeling: what a planner made of the operators.
        task_categories: transition modeling: the task's categories, with blanks between.
        characters: the length of the answer.
        output_tokens: what it took, where a run counted it.
        cost: in dollars, likewise.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class StepLine(TidyLine):
    """One step of a plan, or of the way in which subgoals are carried out, that was tried.

    Attributes:
        step: its number, from 0.
        operator: the action.
        objects: its objects, with blanks between.
        outcome: ``executed``, ``planned``, or the kind of error.
        reason: which check failed, in words.
    """

    step: int
    operator: str
    objects: str
    outcome: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalLine(TidyLine):
    """One goal of a task, and whether an answer with a plan or subgoals reaches it.

    Attributes:
        goal: its number, from 0.
        kind: ``state``, ``relation`` or ``action``.
        text: the goal.
        predicates: the predicates it mentions, or its actions, each once, with blanks between.
        satisfied: whether it is reached.
    """

    goal: int
    kind: str
    text: str
    predicates: str
    satisfied: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class AtomLine(TidyLine):
    """One goal that an answer to goal interpretation states, or should state.

    Attributes:
        verdict: ``matched``, ``wrong`` or ``missing``.
        atom: the goal, as answers state it.
        predicate: its predicate, or the action.
        positive: whether it is to hold.
        reason: of a wrong one, where it comes from (`Reason`), where that is known.
    """

    verdict: str
    atom: str
    predicate: str
    positive: bool
    reason: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ClauseLine(TidyLine):
    """One clause of an operator that an answer to transition modeling writes, or should write.

    Attributes:
        operator: the operator.
        status: what became of it: ``compared``, ``missing``, ``unreadable``, ``hallucinated``.
        side: ``precondition`` or ``effect``.
        verdict: ``matched``, ``additional`` or ``missing``.
        clause: as PDDL.
        predicates: those in it, with blanks between.
        categories: the categories of these, likewise.
    """

    operator: str
    status: str
    side: str
    verdict: str
    clause: str
    predicates: str
    categories: str


TABLES: Mapping[str, type[TidyLine]] = {
    "answers": AnswerLine,
    "steps": StepLine,
    "goals": GoalLine,
    "atoms": AtomLine,
    "clauses": ClauseLine,
}
"""The tidy tables by name, each with the kind of its lines."""


L = TypeVar("L", bound=TidyLine)

SUITE = ("protocol", "domain", "ability")
"""The columns that say what suite a row is of."""

MODEL = "model"
"""The column of models."""

ALL_MODELS = "all models"
"""The name in the place of a model where the answers of all are taken together."""


AnswerMeasure: TypeAlias = Literal["score", "executable", "goals"]
"""The measures that a feature of tasks can be set against."""

WrongGoalReason: TypeAlias = Literal["unknown", "procedural", "initial", "final", "intermediate", "other"]
"""Where a wrong goal may come from; of those that fit the first is meant.

- unknown: its predicate or action is none of the benchmark's.
- procedural: it is an action that is a goal of no task.
- initial: it holds at the start.
- final: it holds at the end of the data set's own plan, and nobody asked for it.
- intermediate: it holds at some time on the way there, neither at the start nor at the end.
- other: none of these.
"""


class SuiteKey(NamedTuple):
    """A suite: the tasks of a benchmark and an ability under a protocol."""

    protocol: str
    domain: str
    ability: str

    def __str__(self) -> str:
        return f"{self.domain} {Ability(self.ability).value.replace('_', ' ')}, {self.protocol}"

    @property
    def file_name(self) -> str:
        """The suite as a part of the name of a file."""
        return f"{self.domain}-{self.ability}-{self.protocol}"


def group_by_suite(lines: Iterable[L]) -> dict[SuiteKey, list[L]]:
    """The lines of each suite, in the order of first mention."""
    return group_pairs((SuiteKey(line.protocol, line.domain, line.ability), line) for line in lines)


def group_by_model(lines: Sequence[L]) -> dict[str, list[L]]:
    """The lines of each model with its agent; before them those of all together, where there are several."""
    models = group_pairs((line.agent, line) for line in lines)
    return models if len(models) < 2 else {ALL_MODELS: list(lines), **models}


def group_by_run(lines: Iterable[L]) -> Iterator[tuple[tuple[str, str, str, str], list[L]]]:
    """The lines of each suite and model, as `by_model` has them, with the cells that name them."""
    for suite, of_suite in group_by_suite(lines).items():
        for model, of_model in group_by_model(of_suite).items():
            yield (*suite, model), of_model


def score_share(answer: AnswerLine) -> Share:
    """The share that an answer adds to the score that its ability is first judged by: success, else F1."""
    if answer.success is not None:
        return Share(int(answer.success), 1)
    if answer.hits is None or answer.extras is None or answer.misses is None:
        return EMPTY_SHARE
    return Share(2 * answer.hits, 2 * answer.hits + answer.extras + answer.misses)


def execution_share(answer: AnswerLine) -> Share:
    """The share that an answer with a plan or subgoals adds to the share of those that are carried out."""
    return EMPTY_SHARE if answer.success is None or answer.executable is None else Share(answer.executable, 1)


def goal_share(answer: AnswerLine) -> Share:
    """The share that an answer with a plan or subgoals adds to the share of goals that are reached."""
    if answer.success is None:
        return EMPTY_SHARE
    met = (answer.state_met, answer.relation_met, answer.action_met)
    total = (answer.state_total, answer.relation_total, answer.action_total)
    return Share(sum(each or 0 for each in met), sum(each or 0 for each in total))


def make_case(line: TidyLine, share: Share) -> Case:
    """The case that a line adds to a rate, with near copies known."""
    return Case(line.task, line.name, share)


MEASURES: Mapping[AnswerMeasure, Callable[[AnswerLine], Share]] = {
    "score": score_share,
    "executable": execution_share,
    "goals": goal_share,
}
"""The share that an answer adds to each measure."""


K = TypeVar("K")


def shares_by_kind(
    lines: Sequence[TidyLine], kinds: Sequence[K], asked: Iterable[K]
) -> Iterator[tuple[K, Estimate]]:
    """Each kind that is asked for, with the share of lines that are of it.

    Args:
        lines: all lines.
        kinds: the kind of each.
        asked: those to tell, in this order.
    """
    of_it, of_others = ([make_case(line, share) for line in lines] for share in (FULL_SHARE, ZERO_SHARE))
    for kind in asked:
        chosen = zip(kinds, of_it, of_others, strict=True)
        yield kind, Estimate.from_cases([case if found == kind else other for found, case, other in chosen])
