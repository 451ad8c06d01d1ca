"""The published gold operators of both households: the tasks of transition modeling."""

from __future__ import annotations

from eai.abilities.transition_modeling.task import Category, OperatorLibrary, TransitionTask
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.households.packs import BEHAVIOR_PDDL, RESOURCES, open_published
from eai.households.published_files import PROBLEMS_MEMBER
from eai.pddl.operator_text import OperatorText
from eai.pddl.reader import read_domain
from eai.tasks.source import TaskSet


class TransitionTasks(TaskSet[TransitionTask]):
    """The tasks of a household.

    Args:
        pack: the published files.
        header_member: the one with the planning domain.

    Attributes:
        domain: what they share.
    """

    def __init__(self, pack: PackFile, header_member: str) -> None:
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
        tasks = {
            task_id: TransitionTask(
                task_id,
                self.domain,
                operators[task_id],
                [category_of(label) for label in categories[task_id]],
                problems[task_id],
            )
            for task_id in pack.read_json("success_task.json")
        }
        super().__init__(tasks, tasks.__getitem__, pack.manifest.sha256)


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
