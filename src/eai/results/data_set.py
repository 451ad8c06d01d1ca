"""Counts the tasks, goals, plans and objects of a data set (paper, Table 2).

A profile holds the features of one task, such as the number of goals. For any benchmark, the module
computes the numbers of the paper's Table 2, beside the numbers that the paper prints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib import resources
from statistics import fmean, median

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.files import parse_toml
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.features import TaskStatistics, compute_features
from eai.logic.traversal import find_predicates
from eai.pddl.model import find_effect_atoms, find_effect_conditions
from eai.pddl.reader import read_action
from eai.results.table import Column, NamedCells, Plain, Table
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import PredicateCategory, Task


@dataclass(frozen=True, slots=True)
class _TaskWithStatistics:
    """A task with its features, such as the number of objects, from the data set and from the domain.

    Attributes:
        task: the task.
        features: numbers of goals, steps, objects and the like.
        asked: the operators that transition modeling asks for in this task; None if the suite of transition
            modeling lacks the task.
    """

    task: Task
    features: TaskStatistics
    asked: TransitionTask | None

    @property
    def plan_operator_names(self) -> set[str]:
        """Names of the different operators in the data set's own plan."""
        return {action.operator for action in self.task.script}

    @property
    def predicate_categories_in_transition_modeling(self) -> list[str]:
        """Predicate categories of the task in transition modeling, the more specific category first."""
        return [] if self.asked is None else [category.value for category in self.asked.categories]

    @property
    def table_row(self) -> dict[str, Plain]:
        """The features as a row of a table; spaces separate several words in one field."""
        return {
            "task": self.task.id,
            "name": self.task.title,
            **asdict(self.features),
            "operators": " ".join(sorted(self.plan_operator_names)),
            "scene_objects": len(self.task.scene.objects),
            "asked_operators": None if self.asked is None else len(self.asked.operators),
            "categories": " ".join(self.predicate_categories_in_transition_modeling),
        }


@dataclass(frozen=True, slots=True)
class _DataSetStatistic:
    """One number that describes a data set, such as its number of tasks.

    Attributes:
        note: a description of the counted quantity.
        printed: the number in the paper; None if the paper does not have it.
        remark: why the paper has another number, or how it was computed; often empty.
    """

    label: str
    value: int | float
    note: str
    printed: int | float | None = None
    remark: str = ""


def profile_tasks(benchmark: Benchmark, source: Source) -> tuple[_TaskWithStatistics, ...]:
    """Return the profile of each task, such as its number of objects, in the order of the data set.

    Raises:
        DataError: the data cannot be obtained or is damaged.
    """
    operator_tasks = benchmark.operator_tasks(source)
    tasks = benchmark.tasks(source).values()
    return tuple(
        _TaskWithStatistics(task, compute_features(task, benchmark), operator_tasks.get(task.id))
        for task in tasks
    )


LONG_PLAN_STEPS = 10
"""Number of steps; plans with more steps count as long (paper, "Data Statistics and Distribution")."""


@cache
def read_paper_statistics(domain: str) -> Mapping[str, tuple[int | float, str]]:
    """Return a mapping from each statistic's label to the paper's number, and to why ours differs (or "").

    The mapping is empty for benchmarks that are not in the paper.
    """
    file = resources.files("eai.results") / "paper" / "dataset_statistics.toml"
    figures = parse_toml(file.read_text(encoding="utf-8")).get(domain, {})
    entries = {
        label: figure if isinstance(figure, dict) else {"printed": figure}
        for label, figure in figures.items()
    }
    return {label: (figure["printed"], figure.get("remark", "")) for label, figure in entries.items()}


def compute_data_set_statistics(benchmark: Benchmark, source: Source) -> list[_DataSetStatistic]:
    """Return the statistics of a benchmark in the paper's order, counted without corrections of the data.

    Missing data is downloaded first.

    Raises:
        DataError: the data cannot be obtained or is damaged.
    """
    own_by_label = {} if benchmark.data.own_figures is None else benchmark.data.own_figures(source)
    printed, source = read_paper_statistics(benchmark.name), replace(source, errata=ErrataChoice.NONE)
    figures = []
    for counted in _compute_all_statistics(benchmark, source):
        value, note = own_by_label.get(counted.label, (counted.value, counted.note))
        figures.append(_DataSetStatistic(counted.label, value, note, *printed.get(counted.label, (None, ""))))
    return figures


def _compute_all_statistics(benchmark: Benchmark, source: Source) -> Iterator[_DataSetStatistic]:
    profiles = profile_tasks(benchmark, source)
    tasks = [profile for profile in profiles if profile.features.goals]
    without_goals = len(profiles) - len(tasks)
    yield _DataSetStatistic(
        "task names", len({profile.task.title for profile in profiles}), "distinct names that tasks share"
    )
    yield _DataSetStatistic("tasks", len(profiles), "the denominator of goal interpretation")
    yield _DataSetStatistic("instructions", len(tasks), f"tasks that have a goal; {without_goals} have none")
    yield from _list_task_counts_by_ability(benchmark, source)
    yield from _list_goal_statistics([profile.features for profile in tasks])
    yield from _list_plan_statistics([profile for profile in tasks if profile.features.annotated_steps])
    yield from _list_object_statistics(tasks)
    operator_tasks = benchmark.operator_tasks(source)
    if operator_tasks:
        yield from _list_operator_statistics(next(iter(operator_tasks.values())).domain)
        yield from _list_category_statistics(profiles)


def _list_task_counts_by_ability(benchmark: Benchmark, source: Source) -> Iterator[_DataSetStatistic]:
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        if ability in PAPER_ABILITIES:
            number = len(benchmark.tasks_for(ability, source))
            yield _DataSetStatistic(
                f"{ability.value.replace('_', ' ')} tasks", number, "tasks in which it is asked for"
            )
    number = len(benchmark.operator_tasks(source))
    yield _DataSetStatistic("transition modeling tasks", number, "tasks in which it is asked for")


def _list_goal_statistics(tasks: Sequence[TaskStatistics]) -> Iterator[_DataSetStatistic]:
    first = "in the first way to meet each goal"
    ground, conditions = [task.ground_goals for task in tasks], [task.goals for task in tasks]
    yield _DataSetStatistic(
        "goals", sum(ground), f"ground conditions {first}, as goal interpretation counts them"
    )
    yield _DataSetStatistic(
        "state goals", sum(task.ground_state_goals for task in tasks), f"of one object, {first}"
    )
    relations = sum(task.ground_relation_goals for task in tasks)
    yield _DataSetStatistic("relation goals", relations, f"of two objects, {first}")
    yield _DataSetStatistic(
        "action goals", sum(task.ground_action_goals for task in tasks), "actions to be taken"
    )
    yield _DataSetStatistic("ground goals per task", _round_mean(ground), f"{sum(ground)} / {len(tasks)}")
    note = "conjuncts of the goals, as action sequencing and subgoal decomposition count them"
    yield _DataSetStatistic("goal conditions", sum(conditions), note)
    yield _DataSetStatistic(
        "goal conditions per task", _round_mean(conditions), f"{sum(conditions)} / {len(tasks)}"
    )
    quantified = sum(task.quantified_goals for task in tasks)
    yield _DataSetStatistic("quantified conditions", quantified, "conjuncts that speak of objects in general")
    options = [task.goal_options for task in tasks]
    note = f"{options.count(1)} tasks have one, the largest number is {max(options, default=0):,}"
    note = f"ways to choose a ground option for each goal; {note}"
    yield _DataSetStatistic("goal options per task", _round_mean(options), note)
    yield _DataSetStatistic("goal options, median", median(options or [0]), "half of the tasks have no more")


def _list_plan_statistics(tasks: Sequence[_TaskWithStatistics]) -> Iterator[_DataSetStatistic]:
    steps = [profile.features.annotated_steps or 0 for profile in tasks]
    yield _DataSetStatistic("trajectories", len(steps), "annotated plans of the instructions")
    if not steps:
        return
    yield _DataSetStatistic("action steps", sum(steps), "of those plans")
    yield _DataSetStatistic(
        "steps per trajectory", _round_mean(steps), f"{sum(steps):,} steps / {len(steps)} plans"
    )
    yield _DataSetStatistic("fewest steps", min(steps), "of the shortest plan")
    yield _DataSetStatistic("most steps", max(steps), "of the longest plan")
    long_plans = [profile for profile in tasks if (profile.features.annotated_steps or 0) > LONG_PLAN_STEPS]
    share = round(100 * len(long_plans) / len(steps), 2)
    yield _DataSetStatistic(
        f"percent longer than {LONG_PLAN_STEPS}", share, f"{len(long_plans)} of {len(steps)} plans"
    )
    names = {profile.task.title for profile in long_plans}
    yield _DataSetStatistic(
        f"names with one longer than {LONG_PLAN_STEPS}", len(names), "task names with at least one such plan"
    )
    actions = {name for profile in tasks for name in profile.plan_operator_names}
    yield _DataSetStatistic("actions", len(actions), "distinct ones in those plans")


def _list_object_statistics(tasks: Sequence[_TaskWithStatistics]) -> Iterator[_DataSetStatistic]:
    task_objects = _round_mean(profile.features.objects for profile in tasks)
    yield _DataSetStatistic("objects per task", task_objects, "that the task is about")
    scene_objects = _round_mean(len(profile.task.scene.objects) for profile in tasks)
    yield _DataSetStatistic("objects per scene", scene_objects, "all, the agent included")


def _list_operator_statistics(library: OperatorLibrary) -> Iterator[_DataSetStatistic]:
    gold = [read_action(text.write_pddl) for text in library.operators.values()]
    condition_predicates = [{*find_predicates(action.precondition)} for action in gold]
    effect_predicates = [
        {*find_predicates(*find_effect_conditions(action.effect))}
        | {atom.predicate for atom in find_effect_atoms(action.effect)}
        for action in gold
    ]
    yield _DataSetStatistic("transition models", len(gold), "annotated operators")
    for label, words in (("preconditions", condition_predicates), ("effects", effect_predicates)):
        empty = sum(not predicates for predicates in words)
        note = "distinct predicates of each operator; 1 if it has none"
        yield _DataSetStatistic(label, sum(map(len, words)) + empty, note)


def _list_category_statistics(profiles: Iterable[_TaskWithStatistics]) -> Iterator[_DataSetStatistic]:
    asked_profiles = [profile for profile in profiles if profile.asked is not None]
    tasks = Counter(
        category
        for profile in asked_profiles
        for category in profile.predicate_categories_in_transition_modeling
    )
    largest = max(len(profile.predicate_categories_in_transition_modeling) for profile in asked_profiles)
    for category in (profile.value for profile in PredicateCategory if tasks[profile.value]):
        label = category.replace("non_", "non-").replace("_", " ")
        yield _DataSetStatistic(
            f"tasks: {label}",
            tasks[category],
            f"of {len(asked_profiles)}; a task has up to {largest} categories",
        )


def _round_mean(numbers: Iterable[int]) -> float:
    values = list(numbers)
    return round(fmean(values), 2) if values else 0.0


def make_statistics_table(title: str, statistics: Sequence[_DataSetStatistic]) -> Table:
    """Return a table of the numbers that describe a data set, such as its number of tasks.

    The table has a column for the paper only if the paper prints numbers of the benchmark.
    """
    columns: list[NamedCells] = [
        ("figure", [row.label for row in statistics]),
        (Column("counted", is_number=True), [_format_number(row.value) for row in statistics]),
        (Column("paper", is_number=True), [_format_number(row.printed) for row in statistics]),
        ("what is counted", [f"{row.note}. {row.remark}" if row.remark else row.note for row in statistics]),
    ]
    if all(row.printed is None for row in statistics):
        del columns[2]
    return Table.from_columns(title, columns)


def _format_number(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.2f}".rstrip("0").rstrip(".")
