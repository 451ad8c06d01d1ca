"""Study the gain of further attempts at a task, the share due to feedback, and actions that fail at random.

More attempts raise success even without feedback. So runs with feedback are compared with runs that have as
many attempts and the same failing actions, but no feedback. Tables call each combination of options an arm.
Attempts at one task depend on each other, and so do attempts at similar tasks. The unit of every interval is
therefore the name of the task, over all seeds and attempts; similar tasks share a name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import TYPE_CHECKING, get_args

from pydantic import Field, model_validator
from typing_extensions import Self

from eai.abilities.declaration import COLUMNS, GRAMMAR, RUNTIME, AnswerOutcome
from eai.abilities.experiment import Experiment, StudySettings
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import (
    AttemptStart,
    EndCondition,
    FeedbackForm,
    FeedbackLevel,
    ReplanningOptions,
)
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.protocols import make_replanning_options_of_protocol
from eai.results.certainty import TaskRateContribution
from eai.results.paper_tables import PaperTable, read_paper_table
from eai.results.plots import MODEL_COLORS, MUTED, RULE, clip_label, draw_line, make_figure
from eai.results.rate import compute_rate
from eai.results.record import Record
from eai.results.runs import RunKey, recount_errors_as_in_paper
from eai.results.summary import (
    drop_later_attempts,
    estimate_share,
    find_answer_outcome,
    make_contributions_by_metric,
)
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.studies.records import StudyRecords, group_runs_by_suite_and_model
from eai.studies.study import (
    Analysis,
    Figures,
    Study,
    make_file_name_and_titled_run_figure,
    make_remarks_on_comparison_with_paper,
)
from eai.studies.variation import VariationOptions
from eai.tasks.options import Options
from eai.world.fault import FaultKind, Notice

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SUCCESS, EXECUTION = "task_success", "execution_success"
_ERRORS = tuple([column.metric for column in COLUMNS if column.group in (GRAMMAR, RUNTIME)])
_NOT_FAILED = (AnswerOutcome.SUCCESS, AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED)


@dataclass(frozen=True, slots=True)
class _ReplanningRunGroup:
    """Runs with equal options of further attempts, one for each seed. Tables call such a group an arm.

    The seed selects the actions that fail at random.

    Attributes:
        experiment: the options of the runs, without the seed.
        runs: the records of each run by its seed, in the order of seeds.
    """

    experiment: Experiment
    runs: Mapping[int | None, Sequence[Record]]

    @property
    def options(self) -> ReplanningOptions:
        """Options of these runs, such as the number of attempts, the feedback, and how often actions slip."""
        return ReplanningOptions.from_experiment(self.experiment) or ReplanningOptions()

    @property
    def label_of_chosen_options(self) -> str:
        """Label of the runs' options, without a seed."""
        return self.experiment.label

    @property
    def max_attempts(self) -> int:
        """Maximum number of attempts at a task, the first attempt included."""
        return self.options.replans + 1

    @property
    def experiment_without_feedback(self) -> Experiment:
        """Options of the runs to compare with: as in this group, but without feedback on failures."""
        return self.experiment.override_settings_with(
            replace(self.options, feedback="none", form="prompt").experiment
        )

    def list_records_up_to_attempt(self, max_attempts: int) -> list[Record]:
        """Return the records of answers for all seeds, without attempts after the given number."""
        return [
            drop_later_attempts(record, max_attempts) for records in self.runs.values() for record in records
        ]

    def list_task_contributions_to_metric(self, metric: str, attempts: int) -> list[TaskRateContribution]:
        """Return for each seed and task the contribution to a metric after a number of attempts."""
        return [
            case
            for records in self.runs.values()
            for case in _list_metric_contributions_within_attempts(records, metric, attempts)
        ]


def _list_metric_contributions_within_attempts(
    records: Sequence[Record], metric: str, max_attempts: int
) -> list[TaskRateContribution]:
    stopped = [drop_later_attempts(record, max_attempts) for record in records]
    return make_contributions_by_metric(stopped, stopped[0].ability).get(metric, [])


def group_runs_by_replanning_options(runs: Sequence[Sequence[Record]]) -> list[_ReplanningRunGroup]:
    """Return the runs of one model and suite, grouped by their options of replanning, whatever their seed.

    Runs without feedback come first. Runs without further attempts are left out.
    """
    by_experiment = group_pairs(
        (
            experiment.override_settings_with(replace(options, slip_seed=None).experiment),
            (options.slip_seed, records),
        )
        for records in runs
        if (experiment := records[0].experiment) is not None
        and (options := ReplanningOptions.from_experiment(experiment)) is not None
    )
    groups = [
        _ReplanningRunGroup(experiment, dict(sorted(by_seed, key=lambda pair: pair[0] or 0)))
        for experiment, by_seed in by_experiment.items()
    ]
    order = [*get_args(FeedbackLevel)]
    return sorted(
        groups,
        key=lambda group: (
            group.options.slip,
            order.index(group.options.feedback),
            group.label_of_chosen_options,
        ),
    )


def make_replanning_tables(groups: Sequence[_ReplanningRunGroup]) -> list[Table]:
    """Return the tables that compare runs with different options of replanning."""
    return [_make_attempts_table(groups), _make_feedback_table(groups), _make_outcomes_table(groups)]


def make_remarks_on_missing_runs(groups: Sequence[_ReplanningRunGroup]) -> list[str]:
    """Return remarks for readers: which groups lack runs without feedback, or runs of a second seed."""
    experiments = {group.experiment for group in groups}
    lone_groups = [
        group.label_of_chosen_options
        for group in groups
        if group.max_attempts > 1 and group.experiment_without_feedback not in experiments
    ]
    texts = []
    if lone_groups:
        texts.append(
            f"No runs without feedback stand beside {', '.join(lone_groups)}, so the effect of feedback is "
            "not known. `eai run` with the same options and `replanning.feedback=none` makes such runs."
        )
    once = [group.label_of_chosen_options for group in groups if group.options.slip and len(group.runs) == 1]
    if once:
        texts.append(
            f"One seed of slips: {', '.join(once)}. The intervals hold for other tasks, but not for other "
            "draws of slips; run more seeds with `replanning.slip_seed`."
        )
    return texts


def estimate_success_by_attempt(group: _ReplanningRunGroup) -> list[Estimate]:
    """Return the success rate after at most 1, 2, ... attempts at each task."""
    return [
        Estimate.from_task_rate_contributions(group.list_task_contributions_to_metric(SUCCESS, number))
        for number in range(1, group.max_attempts + 1)
    ]


@collect_rows_in_table(
    "attempts",
    (
        *("arm", "attempts", "seeds", "task success", "execution success"),
        *(kind.replace("_", " ") for kind in _ERRORS),
        *("slip", "attempts used", "tokens"),
    ),
)
def _make_attempts_table(groups: Sequence[_ReplanningRunGroup]) -> Iterator[Row]:
    """Results by the number of attempts.

    The result of each arm (options of replanning) after a number of attempts, in percent, with 95 % intervals
    that count tasks with the same name as one unit. Errors are those of the last attempt. A slip (an action
    that was possible but had no effect) is not an error of the model. Success cannot fall, because a success
    ends the attempts. A rise from row to row is therefore no finding by itself. Attempts used and tokens are
    means per task, up to the attempt of the row.
    """
    for group, number in ((item, number) for item in groups for number in range(1, item.max_attempts + 1)):
        records = [
            record for record in group.list_records_up_to_attempt(number) if record.verdict.excluded is None
        ]
        slipped = [r.verdict.error is not None and r.verdict.error.kind is FaultKind.SLIP for r in records]
        cases = [group.list_task_contributions_to_metric(metric, number) for metric in _ERRORS]
        errors = [compute_rate(case.share for case in of_kind).percent for of_kind in cases]
        tokens = [
            sum([attempt.usage.tokens or 0 for attempt in record.attempts if attempt.usage])
            for record in records
        ]
        yield (
            group.label_of_chosen_options,
            number,
            len(group.runs),
            Estimate.from_task_rate_contributions(group.list_task_contributions_to_metric(SUCCESS, number)),
            Estimate.from_task_rate_contributions(group.list_task_contributions_to_metric(EXECUTION, number)),
            *errors,
            estimate_share(records, slipped).value,
            fmean([len(record.attempts) for record in records]) if records else None,
            fmean(tokens) if any(tokens) else None,
        )


@collect_rows_in_table(
    "worth",
    ("arm", "attempts", "told nothing", "with feedback", "difference"),
    title="What feedback is worth",
)
def _make_feedback_table(groups: Sequence[_ReplanningRunGroup]) -> Iterator[Row]:
    """Compare runs with feedback with runs without feedback.

    Each row has the task success of runs without and with feedback after the same number of attempts, on the
    same tasks and seeds. The difference is in percentage points. Both kinds of run ask the same question in
    the first attempt, so a difference after one attempt is due to chance.
    """
    controls = {group.experiment: group for group in groups if group.options.feedback == "none"}
    for group in groups:
        control = controls.get(group.experiment_without_feedback)
        if control is None or control is group:
            continue
        for number in range(1, group.max_attempts + 1):
            one, other = _pair_success_with_and_without_feedback(control, group, number)
            estimates = (
                Estimate.from_task_rate_contributions(one),
                Estimate.from_task_rate_contributions(other),
                Estimate.estimate_rate_difference(one, other),
            )
            yield (group.label_of_chosen_options, number, *estimates)


@collect_rows_in_table(
    "mended",
    ("arm", "first answer", "tasks", "mended", "same", "another"),
    title="What became of first answers that failed",
)
def _make_outcomes_table(groups: Sequence[_ReplanningRunGroup]) -> Iterator[Row]:
    """Count the outcomes of tasks by the outcome of their first answers.

    Tasks are grouped by the error of their first answer. Shown are the percentage of tasks solved in the end,
    and the numbers of tasks that ended with the same error and with another error. Without feedback
    (resampling), later attempts succeed only by chance.
    """
    for group in groups:
        by_kind = group_pairs(
            (find_answer_outcome(drop_later_attempts(record, 1)), record)
            for record in group.list_records_up_to_attempt(group.max_attempts)
        )
        for kind in [kind for kind in AnswerOutcome if kind in by_kind and kind not in _NOT_FAILED]:
            ended = Counter(find_answer_outcome(record) for record in by_kind[kind])
            mended = [find_answer_outcome(record) is AnswerOutcome.SUCCESS for record in by_kind[kind]]
            same, tried = ended[kind], len(mended)
            other = tried - same - ended[AnswerOutcome.SUCCESS]
            label = kind.value.replace("_", " ")
            yield (
                group.label_of_chosen_options,
                label,
                tried,
                estimate_share(by_kind[kind], mended),
                same,
                other,
            )


def _pair_success_with_and_without_feedback(
    without: _ReplanningRunGroup, with_feedback: _ReplanningRunGroup, attempts: int
) -> tuple[list[TaskRateContribution], list[TaskRateContribution]]:
    """Return two lists: success without and with feedback, in tasks and seeds that both groups have."""
    pairs: list[tuple[TaskRateContribution, TaskRateContribution]] = []
    for seed in [seed for seed in with_feedback.runs if seed in without.runs]:
        before = {
            case.task: case
            for case in _list_metric_contributions_within_attempts(without.runs[seed], SUCCESS, attempts)
        }
        after_it = _list_metric_contributions_within_attempts(with_feedback.runs[seed], SUCCESS, attempts)
        pairs += [(before[case.task], case) for case in after_it if case.task in before]
    return [one for one, _ in pairs], [other for _, other in pairs]


_PAPER = ("replanning", "replanning_prose", "replanning_stochastic")
_PAPER_METRICS = ("task_success", "execution_success", "missing_step", "additional_step")
_SCREEN_COLUMNS = (
    *("arm", "attempts", "task success", "execution success"),
    *("told nothing", "with feedback", "difference"),
)
"""Names of the columns that the tables show on the screen."""


class _ReplanningRunOptions(VariationOptions):
    """The number of attempts at a task, the feedback between them, and actions that fail.

    Raises:
        InputError: choices contradict each other.

    Attributes:
        replans: Further attempts at a task that fails.
        world: Where further attempts begin: restart (in the initial state), or continue (in the last state of
            the attempt before).
        feedback: The feedback on a failure: explained (if not given), kind, state, or none (the same question
            again).
        feedback_form: Where feedback is given: prompt (at the end of the question), or chat (as turns of a
            conversation).
        slip: The probability that a possible action does not work.
        slip_seed: The seed of the slips.
        slip_notice: Whether a slip is noticed: detected, or silent.
        until: An attempt ends with its plan (done), or in the first state with all goals (goal; if not given,
            where the world continues).
        preset: A protocol: the slips of its published script, three replans, the state as feedback.
    """

    replans: int = Field(default=0, ge=0)
    world: AttemptStart = "restart"
    feedback: FeedbackLevel | None = None
    feedback_form: FeedbackForm = "prompt"
    slip: float = Field(default=0.0, ge=0, le=1)
    slip_seed: int = 0
    slip_notice: Notice = "detected"
    until: EndCondition | None = None
    preset: str = ""

    @model_validator(mode="after")
    def _check_options(self) -> Self:
        _ = self.replanning
        return self

    @property
    def option_that_enables_study(self) -> str:
        """Options that switch this study on, as messages name them; empty if the user chose none of them."""
        return "replanning.replans, slip or until" if self.replanning else ""

    @property
    def results_heading(self) -> str:
        """Heading above the results of a run: the label of the options; empty for a plain run."""
        return self.replanning.label if self.replanning else ""

    def select_abilities(self, requested: Collection[Ability]) -> list[Ability]:
        """Return action sequencing, the only ability in which a model may try again.

        Raises:
            InputError: another ability is named.
        """
        for ability in requested:
            if ability is not Ability.ACTION_SEQUENCING:
                raise InputError(
                    f"--ability {ability.value}: only plans can be attempted again; choose action_sequencing"
                )
        return [Ability.ACTION_SEQUENCING]

    @property
    def replanning(self) -> ReplanningOptions | None:
        """The options of further attempts; None for a plain run (one attempt at each task, all actions work).

        Some options have no effect with certain other options, such as the seed if no action fails. They get
        the value of a plain run. By default, feedback explains failures. If attempts continue in the last
        state, an attempt ends by default when all goals are reached.
        """
        scripted = make_replanning_options_of_protocol(self.preset, self.slip, self.slip_seed, self.replans)
        if scripted is not None:
            return scripted
        feedback = self.feedback or ("explained" if self.replans else "none")
        if feedback != "none" and not self.replans:
            raise InputError(
                f"replanning.feedback {feedback}: has no effect without further attempts; "
                "also give replanning.replans"
            )
        continues = self.world == "continue" and bool(self.replans)
        options = ReplanningOptions(
            self.replans,
            "continue" if continues else "restart",
            feedback,
            "prompt" if feedback == "none" else self.feedback_form,
            self.slip,
            self.slip_seed if self.slip else None,
            self.slip_notice if self.slip else "detected",
            self.until or ("goal" if continues else "done"),
        )
        return options if options.executes_answers_as_episodes else None

    def make_study_settings_to_store_in_records(self, study_name: str) -> StudySettings | None:
        """Return the settings of replanning as the records of a run store them; None for a plain run."""
        return None if self.replanning is None else self.replanning.experiment.study[study_name]


class _ReplanningAnalysisOptions(Options):
    """How errors are counted.

    Attributes:
        published_counts: Count errors only in tasks that used all attempts, as the published script does.
    """

    published_counts: bool = False


def _analyze_replanning(records: StudyRecords, chosen: _ReplanningAnalysisOptions) -> Iterator[Analysis]:
    """Compare runs with feedback on failures with the run without it (replanning.feedback=none).

    The runs of a comparison have the same model, domain, ability and protocol (scoring rules).

    Raises:
        InputError: there are no such runs.
    """
    acting = (
        run
        for run in records.read_runs()
        if ReplanningOptions.from_experiment(run.key.experiment) is not None
    )
    runs_of_models = list(group_runs_by_suite_and_model(acting).values())
    if not runs_of_models:
        raise InputError(
            "found no records of runs with further attempts, or with actions that fail at random (slips); "
            "make such a run by eai run --with replanning.replans=3"
        )
    for model_runs in runs_of_models:
        key = model_runs[0].key
        place = f"{key.domain}-{key.protocol.value}-{to_file_name(key.model)}"
        counted = map(recount_errors_as_in_paper, model_runs) if chosen.published_counts else model_runs
        groups = group_runs_by_replanning_options([run.records for run in counted])
        made, notes = _make_replanning_tables_and_paper_remarks(groups, key)
        first = replace(made[0], title=f"{key.model}, {key.domain}, protocol {key.protocol.value}")
        yield Analysis(
            made,
            _draw_success_by_attempt_figure(groups, key),
            [*make_remarks_on_missing_runs(groups), *notes],
            place if len(runs_of_models) > 1 else "",
            [first.select_columns(_SCREEN_COLUMNS), made[1].select_columns(_SCREEN_COLUMNS)],
        )


def _make_replanning_tables_and_paper_remarks(
    groups: Sequence[_ReplanningRunGroup], key: RunKey
) -> tuple[list[Table], list[str]]:
    """Return all tables, and remarks on rates in the paper, if the paper has rates for the domain."""
    papers = [
        paper for paper in map(read_paper_table, _PAPER) if any(c.domain == key.domain for c in paper.columns)
    ]
    if not papers:
        return make_replanning_tables(groups), []
    return [
        *make_replanning_tables(groups),
        _make_table_of_rates_printed_in_paper(papers, key.domain),
    ], make_remarks_on_comparison_with_paper(papers, key.protocol)


def _draw_success_by_attempt_figure(groups: Sequence[_ReplanningRunGroup], key: RunKey) -> Figures:
    yield make_file_name_and_titled_run_figure(key, "success_by_attempt", draw_success_by_attempt(groups))


@collect_rows_in_table("paper", ("table", "model", *(metric.replace("_", " ") for metric in _PAPER_METRICS)))
def _make_table_of_rates_printed_in_paper(papers: Sequence[PaperTable], domain: str) -> Iterator[Row]:
    """Rates in the paper.

    Percentages as printed in the paper Embodied Agent Interface. Read the notes above the tables before you
    compare them with other rates.
    """
    for paper in papers:
        columns = {column.metric: column for column in paper.columns if column.domain == domain}
        for name in paper.rows:
            figures = [
                paper.find_printed_number(name, columns[m]) if m in columns else None for m in _PAPER_METRICS
            ]
            yield (paper.title, name, *figures)


_SIZE = (3.5, 2.8)
"""Width and height of the figure without its legend, in inches: one column of a page."""
_LEGEND_ROW = 0.17
_GROUP_DISTANCE = 0.05
"""Horizontal distance between the points of two groups of runs, in attempts (the unit of the axis).

It keeps the error bars of the groups apart.
"""


def draw_success_by_attempt(groups: Sequence[_ReplanningRunGroup]) -> Figure | None:
    """Draw success by attempt with its 95 % intervals; return None if no task had a second attempt."""
    shown = [group for group in groups if group.max_attempts > 1]
    if not shown:
        return None
    figure = make_figure(_SIZE[0], _SIZE[1] + _LEGEND_ROW * len(shown))
    panel = figure.subplots()
    for number, group in enumerate(shown):
        estimates = estimate_success_by_attempt(group)
        places = [
            k + _GROUP_DISTANCE * (number - (len(shown) - 1) / 2) for k in range(1, group.max_attempts + 1)
        ]
        has_feedback = group.options.feedback != "none"
        color, style = (MODEL_COLORS[number % len(MODEL_COLORS)], "o-") if has_feedback else (MUTED, "o--")
        label = f"{clip_label(group.label_of_chosen_options)}, n = {estimates[0].denominator:,.0f}"
        draw_line(panel, places, estimates, color, style, label=label)
    ticks = range(1, max(group.max_attempts for group in shown) + 1)
    panel.set(xlabel="attempts", xticks=ticks, ylabel="task success in percent", ylim=(0, 100))
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=1, frameon=False, fontsize=7)
    return figure


REPLANNING = Study(
    "replanning",
    "Replanning and actions that fail (action sequencing).",
    _ReplanningRunOptions,
    choices=_ReplanningAnalysisOptions,
    analyze=_analyze_replanning,
)
