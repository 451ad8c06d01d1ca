"""The published gold operators of both households: the tasks of transition modeling."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from eai.abilities.transition_modeling.task import Category, OperatorLibrary, TransitionTask
from eai.benchmarks.packs import BEHAVIOR_PDDL, RESOURCES, open_published
from eai.benchmarks.published_files import PROBLEMS_MEMBER
from eai.benchmarks.source import TaskSet
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.pddl.operator_text import OperatorText
from eai.pddl.reader import read_domain

NOTHING_RENAMED: Mapping[str, str] = MappingProxyType({})
"""The names of all operators are those in the data set."""

ASKED_AS: Mapping[str, str] = MappingProxyType({"slice-carvingknife": "slice_carvingknife"})
"""An erratum of BEHAVIOR: the name of an operator in the data set -> the one that its prompts ask for."""


class TransitionTasks(TaskSet[TransitionTask]):
    """The tasks of a household.

    Args:
        pack: the published files.
        header_member: the one with the planning domain.
        asked_as: the names of operators that are asked for by others than those in the data set.

    Attributes:
        domain: what they share.
    """

    def __init__(
        self, pack: PackFile, header_member: str, asked_as: Mapping[str, str] = NOTHING_RENAMED
    ) -> None:
        gold = pack.read_json("gold_action.json")
        names = {name: asked_as.get(name, name) for name in gold}
        self.domain = OperatorLibrary(
            header=read_domain(pack.read(header_member).decode() + ")"),
            operators={
                names[name]: OperatorText(
                    names[name],
                    values["action_parameters"],
                    values["action_preconditions"],
                    values["action_effects"],
                )
                for name, values in gold.items()
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
                [names[name] for name in operators[task_id]],
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


def open_behavior(
    store: Store | None = None, *, asked_as: Mapping[str, str] = ASKED_AS, report: Report = silent
) -> TransitionTasks:
    """BEHAVIOR's 100 tasks, fetched first when they are not there.

    Args:
        store: where they are kept; the user's own store if None.
        asked_as: `ASKED_AS`, or `NOTHING_RENAMED` for the names in the data set.
        report: who is told of a download.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    pack = open_published(BEHAVIOR_PDDL, store, report=report)
    return TransitionTasks(pack, "behavior_pd.pddl", asked_as)
