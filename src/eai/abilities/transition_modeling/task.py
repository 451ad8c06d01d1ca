"""The tasks of transition modeling: gold operators, planning problems and categories of both domains."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from eai.benchmarks.packs import BEHAVIOR_PDDL, RESOURCES, open_published
from eai.benchmarks.published_files import PROBLEMS_MEMBER
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.pddl.model import PddlAction, PddlDomain, PddlProblem
from eai.pddl.operator_text import OperatorText
from eai.pddl.reader import read_action, read_domain, read_problem


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
        return {name: read_action(self.domain.operators[name].pddl) for name in self.operators}

    def gold_answer(self) -> str:
        """The data set's own operators in the form in which answers come."""
        texts = [self.domain.operators[name].pddl for name in self.operators]
        return json.dumps({"output": "\n".join(texts)})


class TransitionTasks(Mapping[str, TransitionTask]):
    """Task id -> task, in the order of the data set.

    Attributes:
        domain: what the tasks share.
        sha256: digest of the data behind them.
    """

    def __init__(self, pack: PackFile, header_member: str) -> None:
        self.sha256 = pack.manifest.sha256
        self.domain = OperatorLibrary(
            header=read_domain(pack.read(header_member).decode() + ")"),
            operators={
                name: OperatorText(
                    name,
                    values["action_parameters"],
                    values["action_preconditions"],
                    values["action_effects"],
                )
                for name, values in pack.read_json("gold_action.json").items()
            },
            categories={
                name: category_of(label) for name, label in pack.read_json("predicates_category.json").items()
            },
        )
        problems = pack.read_json(PROBLEMS_MEMBER)
        operators = pack.read_json("id2action.json")
        categories = pack.read_json("id2category_2.json")
        self._tasks = {
            task_id: TransitionTask(
                task_id,
                self.domain,
                operators[task_id],
                [category_of(label) for label in categories[task_id]],
                problems[task_id],
            )
            for task_id in pack.read_json("success_task.json")
        }

    def __getitem__(self, task_id: str) -> TransitionTask:
        return self._tasks[task_id]

    def __iter__(self) -> Iterator[str]:
        return iter(self._tasks)

    def __len__(self) -> int:
        return len(self._tasks)


def category_of(label: str) -> Category:
    """The category that a label of the data set means: ``non-spatial_relations``, ``object states``, ..."""
    return Category(label.replace("-", "_").replace(" ", "_"))


def open_virtualhome(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """VirtualHome's 296 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return TransitionTasks(open_published(RESOURCES, store, report=report), "virtualhome_pd.pddl")


def open_behavior(store: Store | None = None, *, report: Report = silent) -> TransitionTasks:
    """BEHAVIOR's 100 tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return TransitionTasks(open_published(BEHAVIOR_PDDL, store, report=report), "behavior_pd.pddl")
