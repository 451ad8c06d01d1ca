"""Compare formats of the scene in questions, and measure how errors in a perceived scene lower results.

Answers are grouped by the number and kind of errors in the perceived scene, and by the facts that it lacks.
Rates of errors are always measured in the perceived scene graphs. If errors were drawn at random, these rates
can differ from the rates that the user chose.
Intervals count all answers to tasks of one name as one unit, because tasks recur in runs
and similar tasks share a name.
If there is a run with true scenes, it is compared on the same tasks.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContribution, TaskRateContributions
from eai.results.codec import read_study_summary
from eai.results.plots import ACCENT, COLUMN, MUTED, RULE, make_figure
from eai.results.plots import get_denominator_of_cell as tasks_in
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.summary import make_contributions_by_metric
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.studies.perception.choice import STUDY, ScenePresentationOptions
from eai.studies.perception.declaration import make_numerator_and_denominator_by_rate
from eai.studies.perception.steps import compute_mean_steps
from eai.studies.perception.verdict import ScenePerceptionErrorCounts
from eai.studies.records import StudyRecords, group_runs_by_suite_and_model
from eai.studies.study import Analysis, Figures, Study, choose_metric, make_file_name_and_titled_run_figure
from eai.studies.variation import AskModel, StageThatObtainsGoalsOrScenes
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.base.json_value import Json
    from eai.benchmarks.prompt_library import PromptLibrary
    from eai.benchmarks.suite import Suite
    from eai.results.runs import RunKey


class _PerceptionRunOptions(ScenePresentationOptions):
    """Options for the scene in a run's questions. They also make the stage that obtains these scenes."""

    def make_stage_that_obtains_goals_or_scenes(
        self, library: PromptLibrary, task_ids_by_domain: Mapping[str, Collection[str]], ask: AskModel
    ) -> StageThatObtainsGoalsOrScenes:
        """Return the stage that obtains the scenes (its beliefs) for a run's questions."""
        # Only runs import this module.
        from eai.studies.perception.scenes import collect_scenes_for_prompts

        return StageThatObtainsGoalsOrScenes(
            library, task_ids_by_domain, ask, partial(collect_scenes_for_prompts, self)
        )


PLAIN = "text"
"""Label of a run whose questions list the true scene."""

BOUNDS = (0, 5, 10, 20, 40, 100)
"""Upper bounds of predicate error rates, in percent, by which answers are grouped."""

_NO_PERCEPTION = "no record has a perceived scene; eai run --with perception.scene=noisy records one"

_RATES = ("predicate_error", "missing", "misplaced", "unnecessary", "object_error", "unseen")
_WORST_ORDER = 1000.0
_COSTS = ("cases", "value", "without_errors", "cost")


@dataclass(frozen=True, slots=True)
class _TaskWithPerceptionErrors:
    """The errors in the scene graph of one task in one run, and what the answer adds to the metric.

    Attributes:
        perceived: counts of the errors in the scene graph.
        case: the task, with the numerator and denominator that the answer adds to the metric.
    """

    perceived: ScenePerceptionErrorCounts
    case: TaskRateContribution

    @property
    def percent_of_facts_missing(self) -> float:
        """Share of described facts that are missing or misplaced, in percent; 0 if no fact is described."""
        return Rate(*make_numerator_and_denominator_by_rate(self.perceived)["predicate_error"]).percent or 0.0

    @property
    def perception_error_kinds(self) -> frozenset[str]:
        """Kinds of error in the graph. If the graph lacks whole objects, missing facts are not counted."""
        counts = {
            "missing": 0 if self.perceived.unseen else self.perceived.missing,
            "misplaced": self.perceived.misplaced,
            "unnecessary": self.perceived.unnecessary,
            "object hallucination": self.perceived.invented_names,
            "unseen object": self.perceived.unseen,
        }
        return frozenset([kind for kind, count in counts.items() if count])

    @property
    def predicates_with_missing_facts(self) -> frozenset[str]:
        """Names of predicates of missing or misplaced true facts (`ScenePerceptionErrorCounts`)."""
        return frozenset([name for name, counts in self.perceived.predicates.items() if counts[2]])

    def make_contribution_to_rate(self, share: Share) -> TaskRateContribution:
        """Return the contribution of this task to a rate: the given numerator and denominator."""
        return self.case._replace(share=share)


_TasksWithPerceptionErrors: TypeAlias = Sequence[_TaskWithPerceptionErrors]


@dataclass(frozen=True)
class _RunsBySceneFormat:
    """The runs of one model on one suite that show the scene in several formats.

    Attributes:
        metric: name of the metric to compare, such as ``task_success``.
        runs: the records of each run, by the label of its scene format; a run with the true scene has the
            label `PLAIN`.
    """

    metric: str
    runs: dict[str, Sequence[Record]]

    @cached_property
    def tasks_with_perception_errors(self) -> list[_TaskWithPerceptionErrors]:
        """The tasks of all runs with their perception errors; see `list_tasks_with_perception_errors`."""
        return [task for name in self.runs for task in self.list_tasks_with_perception_errors(name)]

    def list_tasks_with_perception_errors(self, scene_format_of_run: str) -> list[_TaskWithPerceptionErrors]:
        """Return the tasks of a run whose records have perception errors, with their values of the metric."""
        cases = {case.task: case for case in self.list_task_contributions_to_metric(scene_format_of_run)}
        return [
            _TaskWithPerceptionErrors(perceived, cases[record.task_id])
            for record in self.runs[scene_format_of_run]
            if (perceived := read_study_summary(record, STUDY, ScenePerceptionErrorCounts)) is not None
            and record.task_id in cases
        ]

    def list_task_contributions_to_metric(self, scene_format_of_run: str) -> TaskRateContributions:
        """Return the numerator and denominator that each task of a run adds to the metric."""
        records = self.runs[scene_format_of_run]
        return make_contributions_by_metric(records, records[0].ability).get(self.metric, ())

    @cached_property
    def task_contributions_with_true_scene(self) -> dict[str, TaskRateContribution]:
        """Task id -> numerator and denominator that the task adds to the metric.

        They are from the run whose questions list the true scene.
        """
        if PLAIN in self.runs:
            return {case.task: case for case in self.list_task_contributions_to_metric(PLAIN)}
        return {}

    def make_perception_error_cost_cells(self, group: _TasksWithPerceptionErrors) -> Row:
        """Return cells on a group of tasks: their number, metric, metric with the true scene, difference.

        The last two cells use answers to the same tasks whose questions showed the true scene. The two cells
        are empty if such an answer is missing.
        """
        cases = [task.case for task in group]
        without = [
            self.task_contributions_with_true_scene[case.task]
            for case in cases
            if case.task in self.task_contributions_with_true_scene
        ]
        if not without or len(without) < len(cases):
            return (len(cases), Estimate.from_task_rate_contributions(cases), Estimate(None), Estimate(None))
        cost = Estimate.estimate_rate_difference(cases, without)
        return (
            len(cases),
            Estimate.from_task_rate_contributions(cases),
            Estimate.from_task_rate_contributions(without),
            cost,
        )


def make_scene_format_comparison_tables(runs: Sequence[Sequence[Record]], metric: str) -> list[Table]:
    """Return the tables that compare the scene formats of one model's runs in a suite.

    Args:
        runs: the records of each run.
        metric: name of the metric to compare, such as ``task_success``.

    Raises:
        InputError: no run records a perceived scene.
    """
    compared = _RunsBySceneFormat(metric, {_name_scene_format(records): records for records in runs})
    if not compared.tasks_with_perception_errors:
        raise InputError(_NO_PERCEPTION)
    return [
        _make_runs_table(compared),
        _make_metric_by_error_rate_table(compared),
        _make_error_kinds_table(compared),
        _make_missing_facts_table(compared),
    ]


def _name_scene_format(records: Sequence[Record]) -> str:
    choice = records[0].settings_by_study.get(STUDY)
    return PLAIN if choice is None else str(choice.options["scene"])


@collect_rows_in_table("perception_runs", ("scene", *_RATES, "steps", "value"))
def _make_runs_table(runs: _RunsBySceneFormat) -> Iterator[Row]:
    """{runs.metric} by how the scene is shown.

    One row per run: measured error rates in percent, then {runs.metric}. `predicate_error`: facts of the
    scene that are missing or misplaced; `object_error`: names in the scene graph that the scene does not
    have; `missing`: missing facts among the scene's facts; `misplaced`: misplaced facts among the scene's
    relations; `unnecessary`: untrue facts among those of the graph; `unseen`: objects of the scene that the
    graph does not name. Empty if questions state no scene graph. Sorted by `predicate_error`.
    """
    rates = {name: _estimate_error_rates(runs.list_tasks_with_perception_errors(name)) for name in runs.runs}
    order = {name: -1.0 if row[0].value is None else row[0].value for name, row in rates.items()}
    for name in sorted(rates, key=lambda name: (order[name], name)):
        yield (
            name,
            *rates[name],
            compute_mean_steps(runs.runs[name]),
            Estimate.from_task_rate_contributions(runs.list_task_contributions_to_metric(name)),
        )


def _estimate_error_rates(tasks: _TasksWithPerceptionErrors) -> list[Estimate]:
    """Return the rates of errors in a run's perceived scenes, in percent with intervals."""
    if not tasks:
        return [Estimate(None)] * len(_RATES)
    shares = [(task, make_numerator_and_denominator_by_rate(task.perceived)) for task in tasks]
    return [
        Estimate.from_task_rate_contributions(
            [task.make_contribution_to_rate(of_task[name]) for task, of_task in shares]
        )
        for name in _RATES
    ]


@collect_rows_in_table("perception_rates", ("above", "up_to", *_COSTS))
def _make_metric_by_error_rate_table(runs: _RunsBySceneFormat) -> Iterator[Row]:
    """{runs.metric} by predicate error rate.

    Answers of all runs are grouped by the predicate error rate of the scene graph in their question. The rate
    is 0, or more than `above` and at most `up_to` percent. `cases` is the number of answers in the group; a
    task counts once for each run. `value` is {runs.metric} of these answers. `without_errors` is
    {runs.metric} of answers to the same tasks whose questions show the true scene. `cost` is
    `without_errors` minus `value`, in percentage points.
    Compare columns, not rows: rows have different tasks, and tasks with few facts are more often in the first
    and last row. Graphs in the row of 0 can have unnecessary facts, and can lack objects without facts.
    """
    for low, high in [(0.0, 0.0), *pairwise(BOUNDS)]:
        group = [
            task
            for task in runs.tasks_with_perception_errors
            if task.percent_of_facts_missing == high == 0 or low < task.percent_of_facts_missing <= high
        ]
        if group:
            yield (low, high, *runs.make_perception_error_cost_cells(group))


@collect_rows_in_table("perception_kinds", ("kind", *_COSTS))
def _make_error_kinds_table(runs: _RunsBySceneFormat) -> Iterator[Row]:
    """{runs.metric} by kind of error.

    One row per kind of error, for answers whose scene graphs have errors of this kind only. Missing facts are
    not counted in a graph that lacks whole objects (`unseen object`).
    """
    kinds = sorted(
        {kind for task in runs.tasks_with_perception_errors for kind in task.perception_error_kinds}
    )
    groups = {"none": [task for task in runs.tasks_with_perception_errors if not task.perception_error_kinds]}
    groups |= {
        kind: [task for task in runs.tasks_with_perception_errors if task.perception_error_kinds == {kind}]
        for kind in kinds
    }
    groups["several"] = [
        task for task in runs.tasks_with_perception_errors if len(task.perception_error_kinds) > 1
    ]
    yield from [
        (kind, *runs.make_perception_error_cost_cells(group)) for kind, group in groups.items() if group
    ]


@collect_rows_in_table("perception_predicates", ("predicate", "lost", "all_cases", *_COSTS))
def _make_missing_facts_table(runs: _RunsBySceneFormat) -> Iterable[Row]:
    """Which facts cost most when a scene graph lacks them.

    One row per predicate, sorted by cost. `lost`: percentage of the predicate's true facts that scene graphs
    lack or misplace. `all_cases`: number of answers whose scene graph lacks or misplaces such facts. The
    other columns are {runs.metric} of the answers whose scene graph has only such errors.
    """
    names = sorted(
        {name for task in runs.tasks_with_perception_errors for name in task.predicates_with_missing_facts}
    )
    return sorted([_make_missing_facts_row(name, runs) for name in names], key=_make_cost_sort_key)


def _make_missing_facts_row(predicate: str, runs: _RunsBySceneFormat) -> Row:
    tasks = [task for task in runs.tasks_with_perception_errors if predicate in task.perceived.predicates]
    lost = [task for task in tasks if predicate in task.predicates_with_missing_facts]
    only_lost = [
        task
        for task in lost
        if task.predicates_with_missing_facts == {predicate}
        and task.perception_error_kinds <= {"missing", "misplaced"}
    ]
    counts = [task.perceived.predicates[predicate] for task in tasks]
    shares = [Share(gone, right + gone) for right, _, gone in counts]
    lost_share = Estimate.from_task_rate_contributions(
        [task.make_contribution_to_rate(share) for task, share in zip(tasks, shares, strict=True)]
    )
    return (predicate, lost_share, len(lost), *runs.make_perception_error_cost_cells(only_lost))


def _make_cost_sort_key(row: Row) -> tuple[float, str]:
    """Return the sort key of a table row: highest cost first, then lowest metric, then empty rows."""
    for column, sign in ((6, -1), (4, 1)):
        cell = row[column]
        if isinstance(cell, Estimate) and cell.value is not None:
            return (sign * cell.value, str(row[0]))
    return (_WORST_ORDER, str(row[0]))


class _PerceptionAnalysisOptions(Options):
    """How runs are compared.

    Attributes:
        metric: Which metric of the ability's main table; its first if not given.
    """

    metric: str | None = None


def _analyze_perception(records: StudyRecords, chosen: _PerceptionAnalysisOptions) -> Iterator[Analysis]:
    """Compare runs of one model, domain, ability and protocol (scoring rules).

    A run whose questions state the true scene as text gives the metric without perception errors. Make such a
    run by ``eai run --set eai``. This option chooses the prompts of this package, as in the other runs.

    Raises:
        InputError: no run records a perceived scene.
    """
    groups = [
        (label, group)
        for runs in group_runs_by_suite_and_model(records.read_runs()).values()
        for label, group in group_pairs((_make_key_without_scene(run.key), run) for run in runs).items()
        if any(STUDY in record.summaries for run in group for record in run.records)
    ]
    if not groups:
        raise InputError(_NO_PERCEPTION)
    for label, group in groups:
        key = group[0].key
        metric = choose_metric(key.ability, chosen.metric)
        tables = make_scene_format_comparison_tables([run.records for run in group], metric)
        folder = f"{key.suite.suite_name_for_file_names}-{to_file_name(label)}" if len(groups) > 1 else ""
        yield Analysis(
            tables, _draw_error_rate_figure(tables[0], metric, key._replace(model=label)), folder=folder
        )


def _make_key_without_scene(key: RunKey) -> str:
    """Return the name of a run without its scene format. Runs with equal names are compared."""
    rest = None if key.experiment is None else key.experiment.drop_options_of_study(STUDY)
    return key._replace(experiment=rest).name


def _draw_error_rate_figure(table_of_runs: Table, metric: str, key: RunKey) -> Figures:
    yield make_file_name_and_titled_run_figure(
        key, "success_by_error_rate", draw_success_by_error_rate(table_of_runs, metric)
    )


def draw_success_by_error_rate(table_of_runs: Table, metric: str) -> Figure:
    """Draw a point for each run: its predicate error rate on the x axis, its metric on the y axis.

    The run whose questions show the true scene is a hollow point at an error rate of 0. Other runs without a
    known error rate are left out.
    """
    figure = make_figure(COLUMN, 2.6)
    panel = figure.subplots()
    cases = set[int]()
    for row in table_of_runs.rows:
        rate, value = row[1], row[-1]
        if not isinstance(rate, Estimate) or not isinstance(value, Estimate) or value.value is None:
            continue
        is_seen = rate.value is not None
        if not is_seen and row[0] != PLAIN:
            continue
        cases.add(tasks_in(value))
        percent, color = rate.value or 0.0, ACCENT if is_seen else MUTED
        if value.low is not None and value.high is not None:
            panel.vlines(percent, value.low, value.high, color=color, linewidth=1.0)
        if rate.low is not None and rate.high is not None:
            panel.hlines(value.value, rate.low, rate.high, color=color, linewidth=0.7)
        fill = color if is_seen else "white"
        panel.plot(percent, value.value, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)
    of = " to ".join(f"{number:,}" for number in sorted({min(cases), max(cases)})) if cases else "0"
    panel.set(xlabel=f"facts missing or misplaced, percent (n = {of})", ylim=(0, 102), xlim=(-2, None))
    panel.set_ylabel(f"{metric.replace('_', ' ')} in percent")
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    return figure


def _summarize_perception_errors(
    record: Record, suite: Suite, question_metadata: Mapping[str, Any]
) -> Mapping[str, Json]:
    """Return what the record of an answer stores: the errors in the scene graph that the question stated."""
    from eai.studies.perception.scene_graph import SCENE
    from eai.studies.perception.scenes import read_scene_graphs_for_prompts

    if SCENE not in question_metadata:
        return {}
    scenes = {record.task_id: question_metadata[SCENE]}
    beliefs = read_scene_graphs_for_prompts(record.settings_by_study[STUDY].options["scene"], suite, scenes)
    return beliefs.summaries[record.task_id][STUDY]


PERCEPTION = Study(
    STUDY,
    "How questions show the scene (with prompts.set eai).",
    _PerceptionRunOptions,
    choices=_PerceptionAnalysisOptions,
    analyze=_analyze_perception,
    summarize=_summarize_perception_errors,
)
