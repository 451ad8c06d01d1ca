"""Which tables a report has: those of the paper, one a domain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.protocol import Ability
from eai.metrics.average import AVERAGE
from eai.metrics.goals import GOAL_COLUMNS
from eai.metrics.paper_tables import Column
from eai.metrics.transition_modeling import CATEGORIES, OVERALL

ABILITY_TITLES = {
    Ability.GOAL_INTERPRETATION: "Goal interpretation",
    Ability.SUBGOAL_DECOMPOSITION: "Subgoal decomposition",
    Ability.ACTION_SEQUENCING: "Action sequencing",
    Ability.TRANSITION_MODELING: "Transition modeling",
}
DOMAIN_TITLES = {"virtualhome": "VirtualHome", "behavior": "BEHAVIOR"}


@dataclass(frozen=True, slots=True)
class ColumnSpec:
    """One column.

    Attributes:
        ability: whose metric it shows; None for the average over all abilities.
        metric: its name.
        group: the heading above it and its neighbours.
        label: its own heading.
        more_is_better: whether the largest number is the best, which then is printed in bold.
    """

    ability: Ability | None
    metric: str
    group: str
    label: str
    more_is_better: bool = True

    def place(self, domain: str) -> Column:
        """The column of the paper that shows the same in a domain."""
        return Column(self.ability.value if self.ability else "", self.metric, domain)


@dataclass(frozen=True, slots=True)
class TableSpec:
    """One table.

    Attributes:
        name: a name for files.
        title: a title for readers.
        columns: from left to right.
        primary: the column that ranks; the last resort is the first column with numbers.
        paper: the paper's tables that have these columns, in order of preference.
    """

    name: str
    title: str
    columns: tuple[ColumnSpec, ...]
    primary: str
    paper: tuple[str, ...]


def domain_title(domain: str) -> str:
    """How a domain is called in headings."""
    return DOMAIN_TITLES.get(domain, domain)


def label_of(name: str) -> str:
    """A metric or a kind of error for readers."""
    return name.replace("_", " ").replace(".", " ").capitalize()


def _trajectory(ability: Ability, paper: str) -> TableSpec:
    columns = _trajectory_columns(ability)
    return TableSpec(paper, ABILITY_TITLES[ability], columns, "task_success", (paper, "overview"))


def _trajectory_columns(ability: Ability) -> tuple[ColumnSpec, ...]:
    success = (("task_success", "Task"), ("execution_success", "Execution"))
    grammar = (("parsing", "Parsing"), ("hallucination", "Hallucination"), ("argument_number", "Arguments"))
    runtime = (
        ("wrong_order", "Wrong order"),
        ("missing_step", "Missing step"),
        ("affordance", "Affordance"),
        ("additional_step", "Additional step"),
    )
    return (
        *(ColumnSpec(ability, metric, "Success", label) for metric, label in success),
        *(ColumnSpec(ability, metric, "Grammar errors", label, False) for metric, label in grammar),
        *(ColumnSpec(ability, metric, "Runtime errors", label, False) for metric, label in runtime),
    )


def _scores(ability: Ability, parts: Sequence[str]) -> tuple[ColumnSpec, ...]:
    measures = (("precision", "P"), ("recall", "R"), ("f1", "F1"))
    return tuple(
        ColumnSpec(ability, f"{part}.{measure}", label_of(part), label)
        for part in parts
        for measure, label in measures
    )


def _overview() -> TableSpec:
    goals, subgoals, actions, operators = Ability
    columns = (
        ColumnSpec(goals, "overall.f1", ABILITY_TITLES[goals], "F1"),
        *(
            ColumnSpec(ability, f"{what}_success", ABILITY_TITLES[ability], label)
            for ability in (actions, subgoals)
            for what, label in (("task", "Task"), ("execution", "Execution"))
        ),
        ColumnSpec(operators, f"{OVERALL}.f1", ABILITY_TITLES[operators], "F1"),
        ColumnSpec(operators, f"{OVERALL}.planner_success", ABILITY_TITLES[operators], "Planner"),
        ColumnSpec(None, AVERAGE, "All", "Average"),
    )
    return TableSpec("overview", "Overview", columns, AVERAGE, ("overview",))


def _goal_interpretation() -> TableSpec:
    ability = Ability.GOAL_INTERPRETATION
    faults = (("parsing", "Unreadable"), ("ill_formed", "Ill-formed"), ("hallucination", "Hallucination"))
    columns = (
        *_scores(ability, ("state", "relation", "action", "overall")),
        *(ColumnSpec(ability, metric, "Grammar errors", label, False) for metric, label in faults),
    )
    return TableSpec(
        "goal_interpretation", ABILITY_TITLES[ability], columns, "overall.f1", ("goal_interpretation",)
    )


def _goal_satisfaction() -> TableSpec:
    columns = tuple(
        ColumnSpec(ability, metric, ABILITY_TITLES[ability], label_of(metric.removesuffix("_goal")))
        for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
        for metric in GOAL_COLUMNS
    )
    return TableSpec("goal_satisfaction", "Goal satisfaction", columns, "total_goal", ("goal_satisfaction",))


def _operators() -> tuple[TableSpec, TableSpec]:
    ability = Ability.TRANSITION_MODELING
    parts = (*CATEGORIES, OVERALL)
    title = ABILITY_TITLES[ability]
    logic = TableSpec(
        "transition_modeling_logic",
        f"{title}: logical matching",
        _scores(ability, parts),
        f"{OVERALL}.f1",
        ("transition_modeling_virtualhome_logic", "transition_modeling_behavior_logic", "overview"),
    )
    planner = TableSpec(
        "transition_modeling_planner",
        f"{title}: planner success",
        tuple(ColumnSpec(ability, f"{part}.planner_success", "Planner", label_of(part)) for part in parts),
        f"{OVERALL}.planner_success",
        ("transition_modeling_planner", "overview"),
    )
    return logic, planner


TABLES: tuple[TableSpec, ...] = (
    _overview(),
    _goal_interpretation(),
    _trajectory(Ability.ACTION_SEQUENCING, "action_sequencing_trajectory"),
    _trajectory(Ability.SUBGOAL_DECOMPOSITION, "subgoal_decomposition_trajectory"),
    _goal_satisfaction(),
    *_operators(),
)
"""The tables of a report, in order."""


def _summary_columns() -> tuple[ColumnSpec, ...]:
    ability = Ability.TRANSITION_MODELING
    measures = (("f1", "F1"), ("planner_success", "Planner"))
    return tuple(
        ColumnSpec(ability, f"{part}.{measure}", label_of(part), label)
        for part in CATEGORIES
        for measure, label in measures
    )


COLUMNS_BESIDES: Mapping[str, tuple[ColumnSpec, ...]] = {
    "transition_modeling_summary": _summary_columns(),
    "human": _overview().columns,
    "replanning": _trajectory_columns(Ability.ACTION_SEQUENCING),
    "pipeline_action_sequencing": _trajectory_columns(Ability.ACTION_SEQUENCING),
    "pipeline_subgoal_decomposition": _trajectory_columns(Ability.SUBGOAL_DECOMPOSITION),
}
"""The columns of the paper's tables of a few models, or of other ways to ask, in a domain that has them."""
