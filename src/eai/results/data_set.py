"""Figures of a data set: how many tasks, how long, about what (paper, Table 2).

Profiles say what each task is like. Statistics are the paper's Table 2 of any benchmark, each figure with the
paper's beside it.
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
from eai.benchmarks.features import Features, features_of
from eai.logic.traversal import predicates_of
from eai.pddl.model import effect_atoms, effect_conditions
from eai.pddl.reader import read_action
from eai.results.table import Column, NamedCells, Plain, Table
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import Category, Task


@dataclass(frozen=True, slots=True)
class _Profile:
    """A task with its features, from its data set and its declaration alone.

    Attributes:
        task: the task.
        features: what can be counted of any task.
        asked: what transition modeling asks; None where it is not asked.
    """

    task: Task
    features: Features
    asked: TransitionTask | None

    @property
    def operators(self) -> set[str]:
        """The distinct actions of the data set's own plan."""
        return {action.operator for action in self.task.script}

    @property
    def categories(self) -> list[str]:
        """The task's categories in transition modeling, the more telling one first."""
        return [] if self.asked is None else [each.value for each in self.asked.categories]

    @property
    def row(self) -> dict[str, Plain]:
        """The profile as a flat row; several words in one field are separated by spaces."""
        return {
            "task": self.task.id,
            "name": self.task.title,
            **asdict(self.features),
            "operators": " ".join(sorted(self.operators)),
            "scene_objects": len(self.task.scene.objects),
            "asked_operators": None if self.asked is None else len(self.asked.operators),
            "categories": " ".join(self.categories),
        }


@dataclass(frozen=True, slots=True)
class _Figure:
    """One figure of a data set.

    Attributes:
        note: what is counted.
        printed: the figure as the paper prints it; None if it does not have this one.
        remark: why the paper prints another number, or how it comes to this one; empty if there is nothing
            to say.
    """

    label: str
    value: int | float
    note: str
    printed: int | float | None = None
    remark: str = ""


def profile_tasks(benchmark: Benchmark, source: Source) -> tuple[_Profile, ...]:
    """The profiles of all tasks, in the order of the data set.

    Raises:
        DataError: the data cannot be had.
    """
    asked = benchmark.operators(source)
    tasks = benchmark.tasks(source).values()
    return tuple(_Profile(task, features_of(task, benchmark), asked.get(task.id)) for task in tasks)


LONG = 10
"""A plan is long that has more steps than this (paper, "Data Statistics and Distribution")."""


@cache
def read_paper_statistics(domain: str) -> Mapping[str, tuple[int | float, str]]:
    """Label of a figure -> the paper's, and why another number comes out; nothing for other domains."""
    file = resources.files("eai.results") / "paper" / "dataset_statistics.toml"
    found = parse_toml(file.read_text(encoding="utf-8")).get(domain, {})
    entries = {label: each if isinstance(each, dict) else {"printed": each} for label, each in found.items()}
    return {label: (each["printed"], each.get("remark", "")) for label, each in entries.items()}


def count_figures(benchmark: Benchmark, source: Source) -> list[_Figure]:
    """The figures of a benchmark in the paper's order, counted from the data as published.

    Absent data is fetched first.

    Raises:
        DataError: the data cannot be obtained or is damaged.
    """
    own = {} if benchmark.data.own_figures is None else benchmark.data.own_figures(source)
    printed, source = read_paper_statistics(benchmark.name), replace(source, errata=ErrataChoice.NONE)
    rows = []
    for counted in _figures(benchmark, source):
        value, note = own.get(counted.label, (counted.value, counted.note))
        rows.append(_Figure(counted.label, value, note, *printed.get(counted.label, (None, ""))))
    return rows


def _figures(benchmark: Benchmark, source: Source) -> Iterator[_Figure]:
    profiles = profile_tasks(benchmark, source)
    tasks = [each for each in profiles if each.features.goals]
    idle = len(profiles) - len(tasks)
    yield _Figure(
        "task names", len({each.task.title for each in profiles}), "distinct names that tasks share"
    )
    yield _Figure("tasks", len(profiles), "the denominator of goal interpretation")
    yield _Figure("instructions", len(tasks), f"tasks that have a goal; {idle} have none")
    yield from _suites(benchmark, source)
    yield from _goals([each.features for each in tasks])
    yield from _plans([each for each in tasks if each.features.annotated_steps])
    yield from _objects(tasks)
    asked = benchmark.operators(source)
    if asked:
        yield from _operators(next(iter(asked.values())).domain)
        yield from _categories(profiles)


def _suites(benchmark: Benchmark, source: Source) -> Iterator[_Figure]:
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        if ability in PAPER_ABILITIES:
            number = len(benchmark.tasks_for(ability, source))
            yield _Figure(
                f"{ability.value.replace('_', ' ')} tasks", number, "tasks in which it is asked for"
            )
    number = len(benchmark.operators(source))
    yield _Figure("transition modeling tasks", number, "tasks in which it is asked for")


def _goals(tasks: Sequence[Features]) -> Iterator[_Figure]:
    first = "in the first way to meet each goal"
    ground, conditions = [each.ground_goals for each in tasks], [each.goals for each in tasks]
    yield _Figure("goals", sum(ground), f"ground conditions {first}, as goal interpretation counts them")
    yield _Figure("state goals", sum(each.ground_state_goals for each in tasks), f"of one object, {first}")
    relations = sum(each.ground_relation_goals for each in tasks)
    yield _Figure("relation goals", relations, f"of two objects, {first}")
    yield _Figure("action goals", sum(each.ground_action_goals for each in tasks), "actions to be taken")
    yield _Figure("ground goals per task", _mean(ground), f"{sum(ground)} / {len(tasks)}")
    note = "conjuncts of the goals, as action sequencing and subgoal decomposition count them"
    yield _Figure("goal conditions", sum(conditions), note)
    yield _Figure("goal conditions per task", _mean(conditions), f"{sum(conditions)} / {len(tasks)}")
    quantified = sum(each.quantified_goals for each in tasks)
    yield _Figure("quantified conditions", quantified, "conjuncts that speak of objects in general")
    options = [each.goal_options for each in tasks]
    note = f"{options.count(1)} tasks have one, the largest number is {max(options, default=0):,}"
    note = f"ways to choose a ground option for each goal; {note}"
    yield _Figure("goal options per task", _mean(options), note)
    yield _Figure("goal options, median", median(options or [0]), "half of the tasks have no more")


def _plans(tasks: Sequence[_Profile]) -> Iterator[_Figure]:
    """The figures of those tasks that the data set has a plan of."""
    steps = [each.features.annotated_steps or 0 for each in tasks]
    yield _Figure("trajectories", len(steps), "annotated plans of the instructions")
    if not steps:
        return
    yield _Figure("action steps", sum(steps), "of those plans")
    yield _Figure("steps per trajectory", _mean(steps), f"{sum(steps):,} steps / {len(steps)} plans")
    yield _Figure("fewest steps", min(steps), "of the shortest plan")
    yield _Figure("most steps", max(steps), "of the longest plan")
    long = [each for each in tasks if (each.features.annotated_steps or 0) > LONG]
    share = round(100 * len(long) / len(steps), 2)
    yield _Figure(f"percent longer than {LONG}", share, f"{len(long)} of {len(steps)} plans")
    names = {each.task.title for each in long}
    yield _Figure(f"names with one longer than {LONG}", len(names), "task names with at least one such plan")
    actions = {name for each in tasks for name in each.operators}
    yield _Figure("actions", len(actions), "distinct ones in those plans")


def _objects(tasks: Sequence[_Profile]) -> Iterator[_Figure]:
    about = _mean(each.features.objects for each in tasks)
    yield _Figure("objects per task", about, "that the task is about")
    there = _mean(len(each.task.scene.objects) for each in tasks)
    yield _Figure("objects per scene", there, "all, the agent included")


def _operators(library: OperatorLibrary) -> Iterator[_Figure]:
    gold = [read_action(text.pddl) for text in library.operators.values()]
    before = [{*predicates_of(action.precondition)} for action in gold]
    after = [
        {*predicates_of(*effect_conditions(action.effect))}
        | {atom.predicate for atom in effect_atoms(action.effect)}
        for action in gold
    ]
    yield _Figure("transition models", len(gold), "annotated operators")
    for label, words in (("preconditions", before), ("effects", after)):
        empty = sum(not each for each in words)
        note = "distinct predicates of each operator, of one without any one"
        yield _Figure(label, sum(map(len, words)) + empty, note)


def _categories(profiles: Iterable[_Profile]) -> Iterator[_Figure]:
    asked = [each for each in profiles if each.asked is not None]
    tasks = Counter(category for each in asked for category in each.categories)
    most = max(len(each.categories) for each in asked)
    for category in (each.value for each in Category if tasks[each.value]):
        label = category.replace("non_", "non-").replace("_", " ")
        yield _Figure(
            f"tasks: {label}", tasks[category], f"of {len(asked)}; a task has up to {most} categories"
        )


def _mean(numbers: Iterable[int]) -> float:
    """The mean to two digits, as it is printed."""
    known = list(numbers)
    return round(fmean(known), 2) if known else 0.0


def printed_table(title: str, rows: Sequence[_Figure]) -> Table:
    """Return figures as a table; with the paper's column only if the paper has figures of the benchmark."""
    columns: list[NamedCells] = [
        ("figure", [row.label for row in rows]),
        (Column("counted", is_number=True), [_grouped(row.value) for row in rows]),
        (Column("paper", is_number=True), [_grouped(row.printed) for row in rows]),
        ("what is counted", [f"{row.note}. {row.remark}" if row.remark else row.note for row in rows]),
    ]
    if all(row.printed is None for row in rows):
        del columns[2]
    return Table.from_columns(title, columns)


def _grouped(value: float | None) -> str:
    """A number with its thousands apart; nothing where there is none."""
    if value is None:
        return ""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.2f}".rstrip("0").rstrip(".")
