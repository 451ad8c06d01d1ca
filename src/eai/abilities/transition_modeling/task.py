"""The tasks of transition modeling: gold operators, planning problems and categories of predicates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, lru_cache

from eai.pddl.model import PddlAction, PddlDomain, PddlProblem
from eai.pddl.operator_text import OperatorText
from eai.pddl.reader import read_action, read_problem


class Category(str, Enum):
    """The paper's categories of predicates and, but for the last, of tasks."""

    OBJECT_STATES = "object_states"
    OBJECT_ORIENTATION = "object_orientation"
    OBJECT_AFFORDANCE = "object_affordance"
    SPATIAL_RELATIONS = "spatial_relations"
    NON_SPATIAL_RELATIONS = "non_spatial_relations"
    OBJECT_TOOLS = "object_tools"
    """Predicates that make an object a tool; the paper's tables count them in the total only."""


@dataclass(frozen=True, slots=True)
class OperatorLibrary:
    """What the tasks of one domain share.

    Attributes:
        header: the planning domain without operators.
        operators: the gold operators as text, by name, in the order of the data set.
        categories: predicate -> category.
    """

    header: PddlDomain
    operators: Mapping[str, OperatorText]
    categories: Mapping[str, Category]


class TransitionTask:
    """One task: write these operators so that this problem can be solved.

    Attributes:
        id: the data set's id.
        domain: what all tasks of the domain share.
        operators: the names of the operators that are asked for, in the order of the data set.
        categories: the task's own categories, the first the more telling one.
        problem_text: the planning problem.
    """

    def __init__(
        self,
        task_id: str,
        domain: OperatorLibrary,
        operators: Sequence[str],
        categories: Sequence[Category],
        problem_text: str,
    ) -> None:
        self.id = task_id
        self.domain = domain
        self.operators = tuple(operators)
        self.categories = tuple(categories)
        self.problem_text = problem_text

    @cached_property
    def problem(self) -> PddlProblem:
        """The planning problem."""
        return read_problem(self.problem_text)

    @cached_property
    def gold(self) -> Mapping[str, PddlAction]:
        """The operators that are asked for, as the data set has them."""
        return {name: _gold(self.domain.operators[name].pddl) for name in self.operators}


@lru_cache(maxsize=256)
def _gold(text: str) -> PddlAction:
    """A gold operator, which many tasks ask for."""
    return read_action(text)
