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
from eai.abilities.protocol import PAPER_ABILITIES, Ability, get_ability_sort_key
from eai.benchmarks.registry import get_title
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


def find_paper_column(column: MetricColumn, domain: str) -> PaperColumn:
    """Return the column of the paper's tables with the same metric as a column of ours, for a domain."""
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


def format_ability_title(ability: Ability) -> str:
    """Return the title by which headings name an ability."""
    return get_declaration(ability).title


def format_suite_title(domain: str, ability: Ability) -> str:
    """Return the title by which tables name a suite: benchmark and ability."""
    return f"{get_title(domain)}, {format_ability_title(ability).lower()}"


def _make_columns(ability: Ability) -> tuple[MetricColumn, ...]:
    return tuple(replace(column, ability=ability) for column in get_declaration(ability).columns)


def _make_plan_success_and_error_table_spec(ability: Ability) -> TableSpec:
    columns = tuple(column for column in _make_columns(ability) if column.group != SATISFIED)
    return TableSpec(f"{ability.value}_trajectory", format_ability_title(ability), columns, ("task_success",))


def _make_overview_spec() -> TableSpec:
    columns = tuple(
        MetricColumn(metric, format_ability_title(ability), label, ability=ability)
        for ability in _IN_TABLES
        for metric, label in get_declaration(ability).overview_headings.items()
    )
    return TableSpec("overview", "Overview", (*columns, MetricColumn(AVERAGE, "All", "Average")), (AVERAGE,))


def _make_ability_spec(ability: Ability) -> TableSpec:
    main = tuple(get_declaration(ability).overview_headings)
    return TableSpec(ability.value, format_ability_title(ability), _make_columns(ability), main)


def _make_goal_satisfaction_spec(abilities: Iterable[Ability]) -> TableSpec:
    columns = tuple(
        replace(column, group=format_ability_title(ability))
        for ability in abilities
        for column in _make_columns(ability)
        if column.group == SATISFIED
    )
    return TableSpec("goal_satisfaction", "Goal satisfaction", columns, ("total_goal",))


def _make_operator_specs() -> Iterator[TableSpec]:
    ability = Ability.TRANSITION_MODELING
    title, columns = format_ability_title(ability), _make_columns(ability)
    logic = tuple(column for column in columns if column.group != PLANNER)
    planner = tuple(column for column in columns if column.group == PLANNER)
    yield TableSpec(f"{ability.value}_logic", f"{title}: logical matching", logic, (f"{OVERALL}.f1",))
    works = (f"{OVERALL}.plan_works", f"{OVERALL}.planner_success")
    yield TableSpec(f"{ability.value}_planner", f"{title}: planner success", planner, works)


@cache
def _make_specs_of_paper_ability_tables() -> tuple[TableSpec, ...]:
    """Return the definitions of the tables on the paper's abilities, in order."""
    plans = [ability for ability in _IN_TABLES if get_declaration(ability).answers_are_plans]
    return (
        _make_overview_spec(),
        *[_make_ability_spec(ability) for ability in _IN_TABLES if ability is Ability.GOAL_INTERPRETATION],
        *map(_make_plan_success_and_error_table_spec, plans),
        _make_goal_satisfaction_spec(plans),
        *[
            spec
            for ability in _IN_TABLES
            if ability is Ability.TRANSITION_MODELING
            for spec in _make_operator_specs()
        ],
    )


def make_table_specs(abilities: Iterable[Ability]) -> tuple[TableSpec, ...]:
    """Return the definitions of a report's tables: the paper's, and one for each ability not in the paper."""
    others = sorted(set(abilities).difference(PAPER_ABILITIES), key=get_ability_sort_key)
    return (*_make_specs_of_paper_ability_tables(), *map(_make_ability_spec, others))


def find_table_spec(ability: Ability) -> TableSpec:
    """Return the definition of the first table that shows only results of one ability."""
    if ability not in PAPER_ABILITIES:
        return _make_ability_spec(ability)
    return next(
        spec
        for spec in _make_specs_of_paper_ability_tables()
        if {column.ability for column in spec.columns} == {ability}
    )


def _make_operator_summary_spec() -> TableSpec:
    """Return the definition of the summary table of operators, in the layout of the paper."""
    ability = Ability.TRANSITION_MODELING
    measures = (("f1", "F1"), ("planner_success", PLANNER))
    columns = tuple(
        MetricColumn(f"{part}.{measure}", get_display_name(part), label, ability=ability)
        for part in CATEGORIES
        for measure, label in measures
    )
    return TableSpec(f"{ability.value}_summary", format_ability_title(ability), columns, ())


def get_columns(name: str) -> tuple[MetricColumn, ...]:
    """Return the columns of the paper's table with this name."""
    return next(
        spec.columns
        for spec in (*_make_specs_of_paper_ability_tables(), _make_operator_summary_spec())
        if spec.name == name
    )
