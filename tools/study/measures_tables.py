"""Measures of statements that figures of the paper decide: one printed figure is computed from others."""

from __future__ import annotations

from claim import Finding
from evidence import Evidence, V
from rates import DIGIT, all_of, if_so

from eai.benchmarks.registry import find_benchmark
from eai.results.paper_tables import PaperColumn, read_paper_table
from eai.tasks.task import GoalKind

TRAJECTORIES = ("action_sequencing_trajectory", "subgoal_decomposition_trajectory")
STOPPING = ("parsing", "hallucination", "argument_number", "wrong_order", "missing_step", "affordance")
"""The errors after which nothing is executed."""

PIPELINES = ("pipeline_action_sequencing", "pipeline_subgoal_decomposition")
ALONE = " (modular)"
"""The ending of a row of a model that is given the goal."""

ROUNDING = 0.5
"""Points by which a sum of seven printed figures may differ from 100."""


def f1_of_goals(evidence: Evidence) -> Finding:
    return _f1_of("goal_interpretation")


def f1_of_operators(evidence: Evidence) -> Finding:
    return _f1_of("transition_modeling_virtualhome_logic", "transition_modeling_behavior_logic")


def errors_add_up(evidence: Evidence) -> Finding:
    """Add the rates of executed answers and of errors that stop an answer."""
    sums = {}
    for name in TRAJECTORIES:
        for model, row in read_paper_table(name).rows.items():
            for column, executed in row.items():
                if column.metric == "execution_success":
                    place = f"{model} ({column.domain[0].upper()}, {name.split('_')[0]})"
                    errors = (_figure(row, column, error) for error in STOPPING)
                    sums[place] = (executed or 0) + sum(errors)
    wrong = [f"{place} {total:.1f}" for place, total in sums.items() if abs(total - 100) > ROUNDING]
    return all_of(
        (len(sums) - len(wrong), len(sums)),
        text=f"executed answers and these errors add up to 100 % in {len(sums) - len(wrong)} of {len(sums)} "
        f"printed rows; else: {', '.join(wrong) or 'none'}",
    )


def figures_of_pipelines(evidence: Evidence) -> Finding:
    """Compare the modular rows of the pipelines' tables with the full tables."""
    wrong, number = [], 0
    for name, other in zip(PIPELINES, TRAJECTORIES, strict=True):
        full = read_paper_table(other).rows
        for row, figures in read_paper_table(name).rows.items():
            model = row.removesuffix(ALONE)
            for column, figure in figures.items() if row.endswith(ALONE) else ():
                number += 1
                gap = abs((figure or 0) - (full[model][column] or 0))
                place = f"{model}, {column.metric.replace('_', ' ')} {figure} for {full[model][column]}"
                wrong.extend([(gap, place)] if gap > DIGIT else [])
    shown = "; ".join(text for _, text in sorted(wrong, reverse=True)[:4])
    return all_of(
        (number - len(wrong), number),
        text=f"{number - len(wrong)} of {number} figures are equal; the furthest apart: {shown or 'none'}",
    )


def success_within_execution(evidence: Evidence) -> Finding:
    """Compare printed rates of success with rates of execution."""
    above, number = [], 0
    for model, row in read_paper_table("overview").rows.items():
        for column, executed in row.items():
            if column.metric == "execution_success" and executed is not None:
                number += 1
                success = _figure(row, column, "task_success")
                if success > executed:
                    above.append(f"{model}, {success} above {executed}")
    return all_of(
        (number - len(above), number),
        text=f"success is at most execution in {number - len(above)} of {number} printed pairs; "
        f"else {'; '.join(above) or 'none'}",
    )


def final_states_are_noisy(evidence: Evidence) -> Finding:
    """Compare facts that are new in VirtualHome's annotated last states with goals on them."""
    new, goals = [], []
    for task in find_benchmark(V).tasks(evidence.published).values():
        if task.annotated_final is not None:
            new.append(len(set(task.annotated_final.facts()) - set(task.initial.facts())))
            goals.append(sum(goal.kind is not GoalKind.ACTION for goal in task.goals))
    more = sum(facts > wanted for facts, wanted in zip(new, goals, strict=True))
    return if_so(
        more > len(new) / 2,
        f"in {more} of {len(new)} tasks the annotated plan brings about more facts than the goal asks for, "
        f"{sum(new) / len(new):.1f} against {sum(goals) / len(new):.1f} on average",
    )


def _figure(row: dict[PaperColumn, float | None], beside: PaperColumn, metric: str) -> float:
    return row[beside._replace(metric=metric)] or 0


def _f1_of(*names: str) -> Finding:
    """Recompute printed F1 from printed precision and recall, within the rounding of all three."""
    wrong, number = [], 0
    for name in names:
        for model, row in read_paper_table(name).rows.items():
            for column, printed in row.items():
                kind, _, metric = column.metric.partition(".")
                precision, recall = (
                    _figure(row, column, f"{kind}.{side}") for side in ("precision", "recall")
                )
                if metric == "f1" and printed is not None and precision + recall:
                    number += 1
                    low, high = (
                        2 * (precision + by) * (recall + by) / (precision + recall + 2 * by) + by
                        for by in (-DIGIT, DIGIT)
                    )
                    if not low - 1e-9 <= printed <= high + 1e-9:
                        mean = 2 * precision * recall / (precision + recall)
                        wrong.append(
                            (
                                abs(mean - printed),
                                f"{model}, {kind.replace('_', ' ')} {printed} for {mean:.1f}",
                            )
                        )
    shown = "; ".join(text for _, text in sorted(wrong, reverse=True)[:4])
    return all_of(
        (number - len(wrong), number),
        text=f"the harmonic mean of both in {number - len(wrong)} of {number} printed figures; "
        f"the furthest away: {shown or 'none'}",
    )
