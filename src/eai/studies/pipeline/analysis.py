"""Find why pipelines solve fewer tasks than single abilities (paper, "Pipeline-based vs modularized").

Two runs are compared on the same tasks. In the modular run, questions state the goals of the task. In the
pipeline, they state goals that a model gave in goal interpretation. Tasks are grouped by the kind of these
goals, such as right or incomplete. With right goals, goal interpretation costs nothing. A search finds the
tasks that a perfect second stage would solve with these goals.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_answers_of_planner, replace_goals_by_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.planning.search import Limits
from eai.results.certainty import TaskRateContribution, TaskRateContributions
from eai.results.comparison import compare_runs
from eai.results.lines import SuiteKey
from eai.results.paper_tables import map_files_to_paper_models, read_paper_table
from eai.results.rate import compute_rate
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import find_task_name, make_contributions_by_metric
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.studies.pipeline.operator_execution import analyze_operators
from eai.studies.pipeline.stage_one import STUDY, read_goal_interpretation_answers
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, format_suite_heading, make_remarks_on_comparison_with_paper
from eai.tasks.source import Source

_MAX_SEARCH_EFFORT = 400
"""Maximum number of states in the search for a plan that reaches the stated goals.

The limit is low, because a search for contradictory goals never ends early."""

_FILE_ONLY_COLUMNS = ("p", "only modular", "only pipeline")
"""Names of columns that are written to files but not shown on the screen."""

_GOAL_GROUPS = ("exactly right", "all, and others", "some missing", "no answer")
"""Groups of tasks, best first, by whether the goals stated in the question are the goals of the task."""

_GOALS = "goals"
"""Label of a pipeline whose questions contain goals from a model's answers, but not subgoals."""

_COMPARED = ("modular", "pipeline", "difference", "p")
_PAPER = ("paper modular", "paper pipeline")
_PERFECT = "perfect stage 2"


def _classify_correctness_of_stated_goals(record: Record) -> str:
    """Return the group (one of `_GOAL_GROUPS`) of an answered task, by the goals that its question stated."""
    if STUDY not in record.summaries:
        return "no answer"
    _, others, missed = record.summaries[STUDY]["goal_counts"]
    return "some missing" if missed else "all, and others" if others else "exactly right"


@dataclass(frozen=True, slots=True)
class _RunsWithTrueAndInterpretedGoals:
    """Two runs of one model on one suite: a modular run and a pipeline.

    Questions of the modular run state the true goals of the tasks. Those of the pipeline state goals that a
    model gave in goal interpretation.

    Attributes:
        modular: the records of the modular run, at least one.
        pipeline: the records of the pipeline, of the same suite under the same protocol.
        reachable: task id -> whether a plan for the stated goals can reach the goals of the task; empty if
            unknown.
        conditions: task id -> for each condition of the task, its predicate and whether the stated goals lack
            the condition; empty if unknown.
        paper: mapping from metrics to the paper's rates for the model's modular run and pipeline.
    """

    modular: Sequence[Record]
    pipeline: Sequence[Record]
    reachable: Mapping[str, bool]
    conditions: Mapping[str, Sequence[tuple[str, bool]]]
    paper: Mapping[str, tuple[float | None, float | None]]

    @property
    def suite(self) -> SuiteKey:
        record = self.modular[0]
        return SuiteKey(record.protocol.value, record.domain, record.ability.value)

    @property
    def pipeline_label(self) -> str:
        """Label of the pipeline: its stated `goals` or `goals and subgoals`, then the run's other options."""
        experiment = self.pipeline[0].experiment or Experiment()
        rest = experiment.drop_options_of_study(STUDY)
        kind = "goals and subgoals" if "subgoals_from" in experiment.study[STUDY].options else _GOALS
        return kind if rest is None else f"{kind}, {rest.label}"

    @property
    def metric(self) -> str:
        return next(iter(get_declaration(self.modular[0].ability).overview_headings))

    def make_tables(self) -> list[Table]:
        """Return the tables that compare both runs. Tables and columns without data are left out."""
        stages, goals = self._make_modular_and_pipeline_rates_table(), self._make_goals_table()
        made = [
            stages if self.paper else stages.drop_columns(_PAPER),
            goals if self.reachable else goals.drop_columns([_PERFECT]),
            self._make_goal_interpretation_table(),
        ]
        if any("subgoals_sha256" in record.summaries.get(STUDY, {}) for record in self.pipeline):
            made.append(self._make_first_failing_ability_table())
        return [*made, self._make_missing_goal_conditions_table()] if self.conditions else made

    @collect_rows_in_table("chain", ("breaks at", "tasks", "share", "success"))
    def _make_first_failing_ability_table(self) -> Iterator[Row]:
        """Where the chain breaks.

        Tasks by the first ability whose answer fails: stated goals miss a goal of the task, subgoals fail
        when they are carried out, or the plan fails. `success`: the plan is right all the same.
        """
        records = self._select_common_records(self.pipeline)
        cases = self._list_contributions_to_main_metric(self.pipeline)
        solved = {case.task for case in cases if case.share.numerator}
        breaks = {
            record.task_id: _find_first_failing_ability(record, is_plan_right=record.task_id in solved)
            for record in records
        }
        for link in (*_PIPELINE_ABILITIES, "nowhere"):
            shares = [
                TaskRateContribution(
                    record.task_id,
                    find_task_name(record),
                    make_rate_contribution_of_answer(breaks[record.task_id] == link),
                )
                for record in records
            ]
            yield (
                link,
                sum(ability == link for ability in breaks.values()),
                Estimate.from_task_rate_contributions(shares),
                Estimate.from_task_rate_contributions([case for case in cases if breaks[case.task] == link]),
            )

    @collect_rows_in_table("stages", ("metric", *_COMPARED, *_PAPER))
    def _make_modular_and_pipeline_rates_table(self) -> Iterator[Row]:
        """Modular and pipeline.

        Questions of the modular run state the true goals; those of the pipeline state goals that a model
        interpreted. Rates in percent, and pipeline minus modular run in percentage points, with 95 %
        intervals that count tasks with the same name as one unit. p is the p value of the exact permutation
        test: it exchanges the answers of the two runs together for all tasks with the same name. If each task
        has its own name, this is McNemar's test.{self._sentence_about_paper_scores}
        """
        declared = get_declaration(self.modular[0].ability)
        differences = compare_runs(self.modular, self.pipeline).differences
        before, after = (
            make_contributions_by_metric(self._select_common_records(side), declared.ability)
            for side in (self.modular, self.pipeline)
        )
        for metric in declared.terminal_metrics:
            one, other = before.get(metric, []), after.get(metric, [])
            p_value = differences[metric].p_value if metric in differences else None
            yield (
                metric,
                *_estimate_both_rates_and_difference(one, other),
                p_value,
                *self.paper.get(metric, (None, None)),
            )

    @property
    def _sentence_about_paper_scores(self) -> str:
        return " Beside them the paper's figures for this model." if self.paper else ""

    @collect_rows_in_table("goals", ("goals", "tasks", *_COMPARED, "only modular", "only pipeline", _PERFECT))
    def _make_goals_table(self) -> Iterator[Row]:
        """Success by the verdict on the stated goals.

        Questions of the modular run state the true goals; those of the pipeline state goals that a model
        interpreted. Tasks are grouped by the verdict on the model's goals under protocol strict. The table
        shows the success of both runs, and the numbers of tasks that only one run solves. Wrong goals,
        ill-formed goals and goals with unknown names are in the group of other
        goals.{self._sentence_about_perfect_planner}
        """
        kinds = {
            record.task_id: _classify_correctness_of_stated_goals(record)
            for record in self._select_common_records(self.pipeline)
        }
        modular_cases, pipeline_cases = map(
            self._list_contributions_to_main_metric, (self.modular, self.pipeline)
        )
        for kind in (*_GOAL_GROUPS, "all"):
            tasks = {task for task, own_kind in kinds.items() if kind in (own_kind, "all")}
            if tasks:
                modular = self._select_records(self.modular, tasks)
                pipeline = self._select_records(self.pipeline, tasks)
                success = next(iter(compare_runs(modular, pipeline).differences.values()))
                only = len(success.only_first), len(success.only_second)
                one = [case for case in modular_cases if case.task in tasks]
                other = [case for case in pipeline_cases if case.task in tasks]
                perfect = [
                    case._replace(
                        share=make_rate_contribution_of_answer(self.reachable.get(case.task, False))
                    )
                    for case in other
                ]
                compared = *_estimate_both_rates_and_difference(one, other), success.p_value
                yield (kind, len(tasks), *compared, *only, Estimate.from_task_rate_contributions(perfect))

    @property
    def _sentence_about_perfect_planner(self) -> str:
        if not self.reachable:
            return ""
        return (
            " A perfect stage 2 finds a plan for the stated goals by search, if there is one, and is judged "
            "under strict. It is no upper bound, because a model can also reach goals that its question did "
            "not state."
        )

    @collect_rows_in_table("stage_1", ("answer", "tasks", "pipeline"))
    def _make_goal_interpretation_table(self) -> Iterator[Row]:
        """Outcomes of the first stage.

        In the first stage, a model answers goal interpretation. For each defect of its answers: number of
        tasks, and success in the pipeline. Tasks with such defects count in the other tables, too.
        """
        records = self._select_common_records(self.pipeline)
        kinds: dict[str, Callable[[Record], bool]] = {
            "no answer": lambda record: STUDY not in record.summaries,
            "unreadable, so that no goals were stated": _make_test_that_summary_field_is_set(
                "stage_1_unreadable"
            ),
            "names what does not exist": _make_test_that_summary_field_is_set("stage_1_unknown"),
            "has ill-formed entries": _make_test_that_summary_field_is_set("stage_1_left_out"),
        }
        cases = self._list_contributions_to_main_metric(self.pipeline)
        for heading, is_so in kinds.items():
            tasks = {record.task_id for record in records if is_so(record)}
            of_kind = [case for case in cases if case.task in tasks]
            yield heading, len(tasks), Estimate.from_task_rate_contributions(of_kind)

    @collect_rows_in_table("missed", ("condition", "missing", "tasks", "modular solves", "pipeline solves"))
    def _make_missing_goal_conditions_table(self) -> Iterator[Row]:
        """Which conditions are missing.

        Each row is about one predicate. The first number is the share of the tasks' conditions that the
        stated goals lack. The other numbers count the tasks that lack a condition, and the tasks among them
        that each run solves.
        """
        names = {
            record.task_id: find_task_name(record) for record in self._select_common_records(self.pipeline)
        }
        by_condition = group_pairs(
            (condition, TaskRateContribution(task, name, make_rate_contribution_of_answer(missed)))
            for task, name in names.items()
            for condition, missed in self.conditions.get(task, ())
        )
        cases_of_runs = [*map(self._list_contributions_to_main_metric, (self.modular, self.pipeline))]
        for condition in sorted(
            by_condition, key=lambda c: (-sum(case.share.numerator for case in by_condition[c]), c)
        ):
            tasks = {case.task for case in by_condition[condition] if case.share.numerator}
            solved = [
                int(compute_rate(case.share for case in cases if case.task in tasks).numerator)
                for cases in cases_of_runs
            ]
            yield (
                condition,
                Estimate.from_task_rate_contributions(by_condition[condition]),
                len(tasks),
                *solved,
            )

    def _list_contributions_to_main_metric(self, run_records: Sequence[Record]) -> TaskRateContributions:
        """Return the contributions to a run's main metric of the tasks that both runs have scored.

        The result is empty if no task is answered.
        """
        records = self._select_common_records(run_records)
        return make_contributions_by_metric(records, self.modular[0].ability).get(self.metric, ())

    def _select_common_records(self, run_records: Sequence[Record]) -> list[Record]:
        """Return the records (stored verdicts) of one run on tasks that both runs of a pair have scored."""
        scored = [
            {record.task_id for record in records if record.verdict.excluded is None}
            for records in (self.modular, self.pipeline)
        ]
        return self._select_records(run_records, scored[0] & scored[1])

    def _select_records(self, run_records: Sequence[Record], tasks: Collection[str]) -> list[Record]:
        return [record for record in run_records if record.task_id in tasks]


def _make_test_that_summary_field_is_set(field: str) -> Callable[[Record], bool]:
    """Return a function that tests whether the summary of an answer's stated goals has a value in a field.

    An empty text and 0 do not count as values.
    """
    return lambda record: bool(record.summaries.get(STUDY, {}).get(field))


_PIPELINE_ABILITIES = ("goal interpretation", "subgoal decomposition", "action sequencing")
"""Abilities (kinds of question) that a pipeline asks for, in order: goals, then subgoals, then a plan."""


def _find_first_failing_ability(record: Record, *, is_plan_right: bool) -> str:
    """Return the first ability of a pipeline (goals, subgoals, plan) whose answer fails, or "nowhere"."""
    stated = record.summaries.get(STUDY)
    fails = (
        stated is None or bool(stated["goal_counts"][2]),
        stated is None or not stated["subgoals_success"],
        not is_plan_right,
    )
    return next(
        (link for link, is_broken in zip(_PIPELINE_ABILITIES, fails, strict=True) if is_broken), "nowhere"
    )


def _estimate_both_rates_and_difference(
    first: TaskRateContributions, second: TaskRateContributions
) -> tuple[Estimate, Estimate, Estimate]:
    """Return three estimates: the rates of two runs in percent, and the second minus the first in points."""
    return (
        Estimate.from_task_rate_contributions(first),
        Estimate.from_task_rate_contributions(second),
        Estimate.estimate_rate_difference(first, second),
    )


def merge_run_pairs(pairs: Sequence[_RunsWithTrueAndInterpretedGoals]) -> _RunsWithTrueAndInterpretedGoals:
    """Merge pairs of a modular run and a pipeline into one pair with all their records.

    Each task id gets the number of its pair as a prefix, so that a task counts once for each pair. The names
    of tasks, by which intervals group tasks, do not change.
    """
    numbered = list(enumerate(pairs))
    return _RunsWithTrueAndInterpretedGoals(
        [_prefix_task_id(number, record) for number, pair in numbered for record in pair.modular],
        [_prefix_task_id(number, record) for number, pair in numbered for record in pair.pipeline],
        {f"{number} {task}": value for number, pair in numbered for task, value in pair.reachable.items()},
        {f"{number} {task}": value for number, pair in numbered for task, value in pair.conditions.items()},
        {},
    )


def _prefix_task_id(number: int, record: Record) -> Record:
    return replace(record, task_id=f"{number} {record.task_id}")


def _list_goal_predicates_and_whether_missed(scorer: Scorer, answer: str) -> Iterator[tuple[str, bool]]:
    """Yield the predicate of each goal of a task, and whether an answer lacks this goal."""
    assessed = scorer.assess(answer)
    if isinstance(assessed.verdict, GoalVerdict):
        atoms = assessed.explain()
        for conditions, missed in ((assessed.verdict.matched, False), (assessed.verdict.missing, True)):
            yield from (
                (atoms.get_atom_or_action(condition).name_with_negation, missed) for condition in conditions
            )


def analyze_pipelines(
    records: StudyRecords, goal_answers_path: Path | None, *, search_for_plans: bool
) -> Iterator[Analysis]:
    """Yield an analysis of operators in answers, then of each pipeline, and of all pipelines of a suite.

    A pipeline is a run whose questions state goals that a model gave before. A suite has all tasks of a
    benchmark for one ability.

    Args:
        records: the records (stored verdicts on answers).
        goal_answers_path: file or folder with answers to goal interpretation; None if they are not available.
        search_for_plans: whether to search for plans that reach the stated goals.

    Raises:
        InputError: nothing can be analyzed: no run of transition modeling has the default protocol, and no
            pipeline has a run with the true goals to compare.
    """
    runs = list(records.read_runs())
    chains = list(analyze_operators(runs, records))
    yield from chains
    if chains and not any(map(_has_questions_with_interpreted_goals, runs)):
        return
    pairs = [
        _make_runs_with_true_and_interpreted_goals(
            *two, records.source, goal_answers_path, search_for_plans=search_for_plans
        )
        for two in _pair_modular_and_pipeline_runs(records, runs)
    ]
    if not pairs and not chains:
        raise InputError(
            "no pipeline can be compared: also give the records of a run without a pipeline, of the same "
            "model, domain, ability and protocol"
        )
    for (suite, chain), of_kind in group_pairs(
        ((pair.suite, pair.pipeline_label), pair) for pair in pairs
    ).items():
        for pair in of_kind:
            record = pair.pipeline[0]
            label = "" if record.experiment is None else record.experiment.label
            folder = (
                f"{suite.suite_name_for_file_names}/{to_file_name(record.model)}/{label}"
                if len(pairs) > 1
                else ""
            )
            yield _make_pair_analysis(pair, f"{record.model}, {label}", folder)
        if len(of_kind) > 1:
            folder = (
                f"{suite.suite_name_for_file_names}/{to_file_name(chain)}"
                if chain != _GOALS
                else suite.suite_name_for_file_names
            )
            yield _make_pair_analysis(merge_run_pairs(of_kind), f"{len(of_kind)} pipelines", folder)


def _pair_modular_and_pipeline_runs(records: StudyRecords, runs: Sequence[Run]) -> Iterator[tuple[Run, Run]]:
    """Yield pairs: a modular run (true goals in questions), and a pipeline that differs only in its goals."""
    plain = {run.key: run for run in runs if not _has_questions_with_interpreted_goals(run)}
    pipelines = [run for run in runs if _has_questions_with_interpreted_goals(run)]
    if not pipelines:
        raise InputError(
            "expected records of a pipeline (from eai run --with pipeline.goals=own, or eai score --goals), "
            "or records of transition modeling under protocol strict"
        )
    for run in sorted(pipelines, key=lambda run: run.key.sort_key):
        experiment = run.key.experiment
        other = None if experiment is None else experiment.drop_options_of_study(STUDY)
        alone = plain.get(run.key._replace(experiment=other))
        if alone is None:
            records.note(f"left out, because it has no modular run: {run.key}")
        else:
            yield alone, run


def _has_questions_with_interpreted_goals(run: Run) -> bool:
    return run.key.experiment is not None and STUDY in run.key.experiment.study


def _make_runs_with_true_and_interpreted_goals(
    modular: Run, pipeline: Run, source: Source, goal_answers_path: Path | None, *, search_for_plans: bool
) -> _RunsWithTrueAndInterpretedGoals:
    key = modular.key
    conditions: Mapping[str, Sequence[tuple[str, bool]]] = {}
    reachable: Mapping[str, bool] = {}
    if goal_answers_path is not None:
        benchmark = find_benchmark(key.domain)
        model = pipeline.records[0].settings_by_study[STUDY].options["goals_from"]
        answers = read_goal_interpretation_answers(goal_answers_path, benchmark, source, model)[1]
        suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION, source=source)
        conditions = {
            task: list(_list_goal_predicates_and_whether_missed(suite.scorer(task), text))
            for task, text in answers.items()
        }
        if search_for_plans:
            tasks = {record.task_id for record in pipeline.records}
            wanted = {task: text for task, text in answers.items() if task in tasks}
            reachable = dict(_check_if_stated_goals_reach_true_goals(benchmark, wanted, source))
    return _RunsWithTrueAndInterpretedGoals(
        modular.records,
        pipeline.records,
        reachable,
        conditions,
        _find_paper_modular_and_pipeline_percents(key),
    )


def _check_if_stated_goals_reach_true_goals(
    benchmark: Benchmark, goal_answers: Mapping[str, str], source: Source
) -> Iterator[tuple[str, bool]]:
    """Yield each task id with whether a plan for a model's goals also reaches the true goals of the task."""
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=source)
    stated = replace_goals_by_answers(benchmark, goal_answers)
    book = open_answers_of_planner(stated, Ability.ACTION_SEQUENCING, source, Limits(_MAX_SEARCH_EFFORT))
    for task_id in suite.task_ids:
        if task_id in goal_answers:
            success = getattr(suite.score(task_id, book[task_id].text), "success", False)
            yield task_id, bool(success)


def _find_paper_modular_and_pipeline_percents(key: RunKey) -> Mapping[str, tuple[float | None, float | None]]:
    """Return metric -> the paper's percentages for a model, first of its modular run, then of its pipeline.

    Questions of the modular run state the true goals; those of the pipeline state goals that a model
    interpreted.
    """
    name = map_files_to_paper_models().get(key.model)
    paper = read_paper_table(f"pipeline_{key.ability.value}")
    columns = [column for column in paper.columns if column.domain == key.domain]
    rows = [f"{name} ({kind})" for kind in ("modular", "pipeline")]
    if not all(row in paper.rows for row in rows):
        return {}
    return {
        column.metric: (
            paper.find_printed_number(rows[0], column),
            paper.find_printed_number(rows[1], column),
        )
        for column in columns
    }


def _make_pair_analysis(pair: _RunsWithTrueAndInterpretedGoals, title: str, folder: str) -> Analysis:
    tables, record = pair.make_tables(), pair.modular[0]
    heading = f"{title}, {format_suite_heading(pair.suite)}"
    goals = next(table for table in tables if table.name == "goals")
    papers = [read_paper_table(f"pipeline_{record.ability.value}")] if pair.paper else []
    remarks = make_remarks_on_comparison_with_paper(papers, record.protocol) if papers else []
    return Analysis(tables, (), remarks, folder, [_shorten_table_for_terminal(goals, heading)])


def _shorten_table_for_terminal(table: Table, heading: str) -> Table:
    """Return a table for the screen: solved tasks, and differences in percentage points, no intervals."""
    shown = table.drop_columns(_FILE_ONLY_COLUMNS)
    return replace(
        shown,
        title=f"{heading}: tasks solved, difference in points",
        rows=tuple([tuple(map(_format_screen_cell, row)) for row in shown.rows]),
    )


def _format_screen_cell(cell: object) -> str:
    if not isinstance(cell, Estimate):
        return str(cell)
    if cell.value is None:
        return "-"
    return f"{cell.value:+.1f}" if cell.numerator is None else f"{cell.numerator:g}"
