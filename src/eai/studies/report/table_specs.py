"""Define the tables of a report: the paper's tables by domain, with the columns that abilities declare."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache

from eai.abilities.declaration import (
    OVERALL,
    PLANNER,
    SATISFIED,
    MetricColumn,
    get_declaration,
    get_display_name,
)
from eai.abilities.protocol import PAPER_ABILITIES, Ability, ability_rank
from eai.benchmarks.registry import title_of
from eai.results.paper_tables import PaperColumn
from eai.results.summary import AVERAGE
from eai.tasks.task import CATEGORIES

_ORDER = (
    Ability.GOAL_INTERPRETATION,
    Ability.ACTION_SEQUENCING,
    Ability.SUBGOAL_DECOMPOSITION,
    Ability.TRANSITION_MODELING,
)
_IN_TABLES = tuple([ability for ability in _ORDER if ability in PAPER_ABILITIES])
"""The abilities of the paper, in the order of the paper's tables."""


def place_of_column(column: MetricColumn, domain: str) -> PaperColumn:
    """Return the paper's column for the metric of a table's column, in a domain."""
    return PaperColumn(column.ability.value if column.ability else "", column.metric, domain)


@dataclass(frozen=True, slots=True)
class TableSpec:
    """The definition of one table of a report.

    Attributes:
        name: name of the table in files.
        title: title of the table for readers.
        columns: columns from left to right.
        primary: metrics by which rows may be ranked. The first metric with numbers is used, or else the first
            column.
    """

    name: str
    title: str
    columns: tuple[MetricColumn, ...]
    primary: tuple[str, ...]


def ability_title(ability: Ability) -> str:
    """Return the title by which headings name an ability."""
    return get_declaration(ability).title


def suite_title(domain: str, ability: Ability) -> str:
    """Return the title by which tables name a suite: benchmark and ability."""
    return f"{title_of(domain)}, {ability_title(ability).lower()}"


def _columns(ability: Ability) -> tuple[MetricColumn, ...]:
    return tuple(replace(column, ability=ability) for column in get_declaration(ability).columns)


def _trajectory(ability: Ability) -> TableSpec:
    columns = tuple(column for column in _columns(ability) if column.group != SATISFIED)
    return TableSpec(f"{ability.value}_trajectory", ability_title(ability), columns, ("task_success",))


def _overview() -> TableSpec:
    columns = tuple(
        MetricColumn(metric, ability_title(ability), label, ability=ability)
        for ability in _IN_TABLES
        for metric, label in get_declaration(ability).overview_headings.items()
    )
    return TableSpec("overview", "Overview", (*columns, MetricColumn(AVERAGE, "All", "Average")), (AVERAGE,))


def _one_table(ability: Ability) -> TableSpec:
    main = tuple(get_declaration(ability).overview_headings)
    return TableSpec(ability.value, ability_title(ability), _columns(ability), main)


def _goal_satisfaction(abilities: Iterable[Ability]) -> TableSpec:
    columns = tuple(
        replace(column, group=ability_title(ability))
        for ability in abilities
        for column in _columns(ability)
        if column.group == SATISFIED
    )
    return TableSpec("goal_satisfaction", "Goal satisfaction", columns, ("total_goal",))


def _operators() -> Iterator[TableSpec]:
    ability = Ability.TRANSITION_MODELING
    title, columns = ability_title(ability), _columns(ability)
    logic = tuple(column for column in columns if column.group != PLANNER)
    planner = tuple(column for column in columns if column.group == PLANNER)
    yield TableSpec(f"{ability.value}_logic", f"{title}: logical matching", logic, (f"{OVERALL}.f1",))
    works = (f"{OVERALL}.plan_works", f"{OVERALL}.planner_success")
    yield TableSpec(f"{ability.value}_planner", f"{title}: planner success", planner, works)


@cache
def _paper_tables() -> tuple[TableSpec, ...]:
    """Return the definitions of the tables on the paper's abilities, in order."""
    plans = [ability for ability in _IN_TABLES if get_declaration(ability).has_plans]
    return (
        _overview(),
        *[_one_table(ability) for ability in _IN_TABLES if ability is Ability.GOAL_INTERPRETATION],
        *map(_trajectory, plans),
        _goal_satisfaction(plans),
        *[spec for ability in _IN_TABLES if ability is Ability.TRANSITION_MODELING for spec in _operators()],
    )


def tables_of(abilities: Iterable[Ability]) -> tuple[TableSpec, ...]:
    """Return the definitions of a report's tables: the paper's tables, and one for each other ability."""
    others = sorted(set(abilities).difference(PAPER_ABILITIES), key=ability_rank)
    return (*_paper_tables(), *map(_one_table, others))


def find_table(ability: Ability) -> TableSpec:
    """Return the definition of the first table that shows only results of one ability."""
    if ability not in PAPER_ABILITIES:
        return _one_table(ability)
    return next(spec for spec in _paper_tables() if {column.ability for column in spec.columns} == {ability})


def _operators_summary() -> TableSpec:
    """Return the summary table of operators, in the layout of the paper."""
    ability = Ability.TRANSITION_MODELING
    measures = (("f1", "F1"), ("planner_success", PLANNER))
    columns = tuple(
        MetricColumn(f"{part}.{measure}", get_display_name(part), label, ability=ability)
        for part in CATEGORIES
        for measure, label in measures
    )
    return TableSpec(f"{ability.value}_summary", ability_title(ability), columns, ())


def columns_of(name: str) -> tuple[MetricColumn, ...]:
    """Return the columns of the paper's table with this name."""
    return next(spec.columns for spec in (*_paper_tables(), _operators_summary()) if spec.name == name)
