"""A task: an initial state, goals, and further data from the data set of the task."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, NewType

from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.traversal import find_object_names, is_state_formula, walk_subformulas
from eai.tasks.special import (
    AmbiguousTaskMark,
    HazardousTaskMark,
    PossiblyImpossibleTaskMark,
    SpecialTaskMark,
)

if TYPE_CHECKING:
    from eai.world.action import Action
    from eai.world.state import Scene, State

TaskExclusion = NewType("TaskExclusion", str)
"""Reason why all statistics leave a task out.

It depends on the task (`Task.make_exclusion`), never on an answer.
"""

NO_GOALS = "the task has no goals"
"""The reason why statistics exclude a task without goals: no answer to it can fail."""


class GoalKind(str, Enum):
    """The paper's three kinds of goal: properties of objects, relations of objects, and actions."""

    STATE = "state"
    RELATION = "relation"
    ACTION = "action"


class PredicateCategory(str, Enum):
    """The paper's categories of predicates. All but the last category are also categories of tasks."""

    OBJECT_STATES = "object_states"
    OBJECT_ORIENTATION = "object_orientation"
    OBJECT_AFFORDANCE = "object_affordance"
    SPATIAL_RELATIONS = "spatial_relations"
    NON_SPATIAL_RELATIONS = "non_spatial_relations"
    OBJECT_TOOLS = "object_tools"
    """Predicates that mark an object as a tool. Tables include them in totals, but do not list them."""


CATEGORIES = tuple([each.value for each in PredicateCategory if each is not PredicateCategory.OBJECT_TOOLS])
"""Names of the categories for which tables show separate results, such as ``object_states``."""


@dataclass(frozen=True, slots=True)
class Goal:
    """One goal of a task: a formula about the final state, the executed actions, or the whole execution.

    The formula of an action goal is a disjunction of `Occurs` without arguments, in the order in which the
    data set lists the alternative actions. A formula with temporal operators makes a goal over time
    (`eai.logic.semantics`), for example an event that must come first or must never happen. A goal over time
    is a relation goal if an atom in it has several objects, otherwise a state goal.
    """

    kind: GoalKind
    formula: Formula

    @property
    def is_temporal(self) -> bool:
        """Whether the formula has a temporal operator. The goal is then about the whole execution."""
        return not is_state_formula(self.formula)


@dataclass(frozen=True, slots=True)
class Task:
    """One task of a domain.

    Attributes:
        id: id of the task in the data set.
        title: name that similar tasks share.
        instruction: the task in natural language.
        initial: the state in which a plan starts.
        goals: the goals without duplicates, in the order of the data set.
        relevant: indices of the objects that matter to the task, in the order of the data set.
        script: the plan for the task in the data set; empty if there is no such plan.
        temporal_goal: the goals as one formula of temporal logic, as text; None without such a formula.
        annotated_final: the final state of the plan, as the data set states it; None if it states none.
        unsolvable: the reason why no plan reaches the goals; None if no such reason is known.
        unnamed: indices of objects that operators use but that answers never name, such as recipes.
        special: whether the task may be impossible or ambiguous, or forbids events (`eai.tasks.special`);
            None for other tasks.
        shortest_plan: the shortest known plan; empty if the task does not state it.
        reference_plan: actions that win a game of the task in the standard setting of `eai.agents`; empty if
            the task does not state them.
    """

    id: str
    title: str
    instruction: str
    initial: State
    goals: tuple[Goal, ...]
    relevant: tuple[int, ...]
    script: tuple[Action, ...] = ()
    temporal_goal: str | None = None
    annotated_final: State | None = None
    unsolvable: str | None = None
    unnamed: tuple[int, ...] = ()
    special: SpecialTaskMark | None = None
    shortest_plan: tuple[Action, ...] = ()
    reference_plan: tuple[Action, ...] = ()

    @property
    def has_no_plan(self) -> bool:
        """Whether no plan reaches the goals, so that calling the task impossible is right."""
        return isinstance(self.special, PossiblyImpossibleTaskMark) and bool(self.special.missing)

    @property
    def allows_declining_answers(self) -> bool:
        """Whether an answer may call the task impossible, or ask for the meant object."""
        return isinstance(self.special, (PossiblyImpossibleTaskMark, AmbiguousTaskMark))

    @property
    def planning_object_indices(self) -> tuple[int, ...]:
        """Indices of the objects that a search for a plan uses.

        They are the relevant objects, and the objects that operators use but answers never name (`unnamed`).
        """
        return self.relevant + self.unnamed

    @property
    def scene(self) -> Scene:
        """The objects of the task."""
        return self.initial.scene

    @property
    def without_goals_over_time(self) -> Task:
        """The task without its goals over time (goals about the whole execution)."""
        kept = tuple([goal for goal in self.goals if not goal.is_temporal])
        return self if len(kept) == len(self.goals) else self.replace_goals(kept)

    @property
    def has_goals_in_prompts(self) -> bool:
        """Whether prompts state the goals. Prompts of ambiguous tasks only give the instruction."""
        return not isinstance(self.special, AmbiguousTaskMark)

    @property
    def with_only_goals_stated_in_prompts(self) -> Task:
        """The task with only the goals that prompts state."""
        if not self.has_goals_in_prompts:
            return replace(self, goals=())
        is_untold = isinstance(self.special, HazardousTaskMark) and self.special.untold
        return self.replace_goals(self.goals_not_about_hazards) if is_untold else self

    @property
    def goals_not_about_hazards(self) -> tuple[Goal, ...]:
        """The goals of the task except goals that forbid hazards (events that must not happen)."""
        hazards = len(self.special.hazards) if isinstance(self.special, HazardousTaskMark) else 0
        return self.goals[: len(self.goals) - hazards]

    def replace_goals(self, goals: tuple[Goal, ...]) -> Task:
        """Return the task with other goals. None of them may forbid a hazard (an event that must not happen).

        The returned task does not mark any goal as a goal about a hazard. It has no `shortest_plan` and no
        `reference_plan`, but keeps `script`, the data set's plan for the old goals.
        """
        special = None if isinstance(self.special, HazardousTaskMark) else self.special
        return replace(self, goals=goals, special=special, shortest_plan=(), reference_plan=())

    def make_exclusion(self, reason: str) -> TaskExclusion:
        """Return the exclusion of this task from all statistics, for a reason that no answer influences."""
        return TaskExclusion(reason)

    @property
    def unplannable_reason(self) -> TaskExclusion | None:
        """The reason why statistics of plans exclude the task: it has no goals or no plan.

        None if they include the task.
        """
        reason = self.unsolvable if self.goals else NO_GOALS
        return None if reason is None else self.make_exclusion(reason)

    def find_objects_named_in_goals(self, goals: Iterable[Goal]) -> set[int]:
        """Return the indices of the objects that the given goals of the task name."""
        return {self.scene.index[name] for goal in goals for name in find_object_names(goal.formula)}

    def get_goals_of_kind(self, kind: GoalKind) -> tuple[Goal, ...]:
        """Return the task's goals of one kind, in order."""
        return tuple(goal for goal in self.goals if goal.kind is kind)


def goal(formula: Formula) -> Goal:
    """Return the goal of a formula. The kind of the goal depends on the formula.

    A formula with actions but without temporal operators makes an action goal. Any other formula makes a
    relation goal if an atom in it has several objects, otherwise a state goal.
    """
    parts = tuple(walk_subformulas(formula))
    if is_state_formula(formula) and any(isinstance(part, Occurs) for part in parts):
        return Goal(GoalKind.ACTION, formula)
    relates = any(isinstance(part, Atom) and len(part.arguments) > 1 for part in parts)
    return Goal(GoalKind.RELATION if relates else GoalKind.STATE, formula)
