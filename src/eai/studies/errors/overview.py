"""Draw a Sankey diagram of answers: bands from suites to outcomes, as wide as the number of answers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias, TypeVar

from eai.abilities.declaration import AnswerOutcome, get_display_name
from eai.abilities.protocol import Ability, get_ability_sort_key
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results.lines import AnswerTableLine
from eai.results.plots import INK, MUTED, OUTCOME_COLORS, PAGE, SOFT, draw_flow_band, make_figure
from eai.results.table import Row, Table, collect_rows_in_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 4.4
"""The height of the figure, in inches."""

_GAP = 2.5
"""Vertical distance between two stacked bars, in units of the vertical axis (percent of all answers)."""

_LINE = 3.4
"""Height of a line of text, in units of the vertical axis (percent of all answers)."""

_WIDTH = 0.07
"""Width of a bar, as a share of the distance between columns."""

_MIN_NAMED_PERCENT = 0.3
"""Minimum height of the hatched part of a bar for a label, in percent of all answers.

The hatched part stands for the answers with needless steps.
"""


@collect_rows_in_table(
    "overview", ("protocol", "domain", "ability", "outcome", "answers", "with_additional_steps")
)
def make_outcome_counts_table(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Outcomes of answers, by benchmark and ability.

    Numbers of answers of all models by outcome. `with_additional_steps`: number of these answers with at
    least one step that was not needed. Such a step is skipped, so it never decides the outcome.
    """
    counted = [answer for answer in answers if answer.outcome != AnswerOutcome.EXCLUDED.value]
    suites = group_pairs(((line.protocol, line.domain, line.ability), line) for line in counted)
    for suite in sorted(suites, key=lambda suite: (*suite[:2], get_ability_sort_key(Ability(suite[2])))):
        outcomes = group_pairs((line.outcome, bool(line.additional_steps)) for line in suites[suite])
        for outcome in [kind.value for kind in AnswerOutcome if kind.value in outcomes]:
            yield (*suite, outcome, len(outcomes[outcome]), sum(outcomes[outcome]))


class _ChartBar(NamedTuple):
    """A bar of the figure: its upper edge and its height, in percent of all answers."""

    top: float
    height: float

    @property
    def center_y(self) -> float:
        return self.top - self.height / 2


_WorldAbility: TypeAlias = tuple[str, str]
"""Pair of a world's name and an ability's name; each pair has a bar at the left of the figure."""

_Name = TypeVar("_Name")


def draw_sankey_diagrams_of_outcomes(table: Table) -> Iterator[tuple[str, Figure]]:
    """Draw how many answers of each suite (benchmark and ability) end in each outcome, as flows.

    Yield a file name and a figure for each protocol (scoring rules) with answers to two suites or more.
    """
    for protocol, rows in group_pairs((str(row["protocol"]), row) for row in table.row_dicts()).items():
        counts, needless = Counter[tuple[_WorldAbility, str]](), Counter[str]()
        for row in rows:
            suite, outcome = (str(row["domain"]), str(row["ability"])), str(row["outcome"])
            counts[suite, outcome] += _read_count(row["answers"])
            needless[outcome] += _read_count(row["with_additional_steps"])
        if len({suite for suite, _ in counts}) > 1:
            yield f"flow-all-{protocol}", _draw_sankey_diagram_of_outcomes(counts, needless, protocol)


def _read_count(cell: object) -> int:
    return cell if isinstance(cell, int) else 0


def _draw_sankey_diagram_of_outcomes(
    counts: Mapping[tuple[_WorldAbility, str], int],
    answers_with_additional_steps: Mapping[str, int],
    protocol: str,
) -> Figure:
    """Draw suites as bars on the left, outcomes as bars on the right, and bands of answers between them."""
    total = sum(counts.values())
    percents = {flow: 100 * number / total for flow, number in counts.items()}
    present = {outcome for _, outcome in counts}
    outcomes = [str(kind.value) for kind in AnswerOutcome if kind.value in present]
    suites = list(dict.fromkeys(suite for suite, _ in counts))
    suite_bars = _stack_bars(
        {suite: sum(percents.get((suite, name), 0.0) for name in outcomes) for suite in suites}
    )
    outcome_bars = _stack_bars(
        {name: sum(percents.get((suite, name), 0.0) for suite in suites) for name in outcomes}
    )
    figure = make_figure(PAGE, _HEIGHT)
    panel = figure.subplots()
    panel.set_axis_off()
    panel.set_title(f"Protocol {protocol}, percent of {total:,} answers", fontsize=8)
    _draw_flows_from_suites_to_outcomes(panel, percents, suite_bars, outcome_bars)
    for (domain, ability), bar in suite_bars.items():
        panel.fill_between([-_WIDTH, 0], bar.top - bar.height, bar.top, facecolor=SOFT, linewidth=0)
        text = f"{get_title(domain)}, {get_display_name(ability).lower()} {bar.height:.1f}"
        panel.text(-_WIDTH - 0.03, bar.center_y, text, fontsize=6.5, ha="right", va="center", color=INK)
    _draw_outcome_bars(
        panel, outcome_bars, {name: 100 * answers_with_additional_steps[name] / total for name in outcomes}
    )
    panel.set_xlim(-1.0, 2.2)
    return figure


def _stack_bars(heights: Mapping[_Name, float]) -> dict[_Name, _ChartBar]:
    bars, top = dict[_Name, _ChartBar](), 100.0
    for name, height in heights.items():
        bars[name] = _ChartBar(top, height)
        top -= height + _GAP
    return bars


def _draw_flows_from_suites_to_outcomes(
    panel: Axes,
    percents: Mapping[tuple[_WorldAbility, str], float],
    suite_bars: Mapping[_WorldAbility, _ChartBar],
    outcome_bars: Mapping[str, _ChartBar],
) -> None:
    starts = {suite: bar.top for suite, bar in suite_bars.items()}
    ends = {outcome: bar.top for outcome, bar in outcome_bars.items()}
    for suite in suite_bars:
        for outcome in outcome_bars:
            share = percents.get((suite, outcome), 0.0)
            starts[suite] -= share
            ends[outcome] -= share
            if share:
                band = starts[suite], ends[outcome], share
                draw_flow_band(panel, 0, band, _choose_outcome_color(outcome), alpha=0.55)


def _draw_outcome_bars(
    panel: Axes, bars: Mapping[str, _ChartBar], with_extra_steps: Mapping[str, float]
) -> None:
    """Draw the bars of outcomes with their names. The hatched part has the answers with needless steps."""
    text_top = math.inf
    for outcome, bar in bars.items():
        panel.fill_between(
            [1, 1 + _WIDTH],
            bar.top - bar.height,
            bar.top,
            facecolor=_choose_outcome_color(outcome),
            linewidth=0,
        )
        low, hatched = bar.top - bar.height, with_extra_steps[outcome]
        if hatched:
            panel.fill_between(
                *([1, 1 + _WIDTH], low, low + hatched),
                facecolor="none",
                edgecolor=INK,
                hatch="//////",
                linewidth=0.4,
            )
        text = f"{get_display_name(outcome).lower()} {bar.height:.1f}"
        if hatched >= _MIN_NAMED_PERCENT:
            text += f", {hatched:.1f} with additional steps"
        text_top = min(bar.center_y, text_top - _LINE)
        panel.plot([1 + _WIDTH, 1.17], [bar.center_y, text_top], color=MUTED, linewidth=0.6)
        panel.text(1.19, text_top, text, fontsize=6.5, va="center", color=INK)


def _choose_outcome_color(outcome: str) -> str:
    return OUTCOME_COLORS[AnswerOutcome(outcome)]
