"""Study how much results depend on the wording of prompts (paper, appendix on prompts).

Runs of several models, each with several prompts on the same tasks, form a matrix of one metric. The analysis
answers three questions. Do models agree on the best prompts? How much of the variance is due to prompts?
Does the best of many prompts gain more than chance?
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContributions
from eai.results.comparison import compare_runs
from eai.results.plots import add_title, clip_label, draw_rate_matrix, get_value_of_cell
from eai.results.rate import Rate, compute_rate
from eai.results.record import Record
from eai.results.runs import Run
from eai.results.summary import (
    estimate_share,
    find_answer_outcome,
    find_task_name,
    make_contributions_by_metric,
)
from eai.results.table import Cell, Estimate, Row, Table, collect_rows_in_table
from eai.studies.prompts.choice import STUDY
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Figures, Study, choose_metric
from eai.tasks.options import Options

_ROUNDING = 1e-9

PLAIN = "(no name)"
"""Label of a run with the package's usual prompts, which have no name."""

BEST_PROMPTS = 3

DRAWS = 1000

SEED = 20240901

ALL = "all models"


def compute_kendall_tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Return Kendall's tau-b of two ratings of the same items: 1 for equal orders, -1 for reverse orders.

    Returns:
        the rank correlation tau-b; None if a rating gives all items one value.
    """
    concordant = ties_first = ties_second = 0
    for (a, b), (c, d) in combinations(zip(first, second, strict=True), 2):
        concordant += _get_sign(a - c) * _get_sign(b - d)
        ties_first += a == c
        ties_second += b == d
    pairs = math.comb(len(first), 2)
    scale = (pairs - ties_first) * (pairs - ties_second)
    return concordant / math.sqrt(scale) if scale else None


def compute_kendall_w(ratings: Sequence[Sequence[float]]) -> float | None:
    """Return Kendall's coefficient of concordance W of several ratings of the same items, corrected for ties.

    W is 0 without agreement, and 1 if all ratings have one order. For two ratings, W = (1 + rho) / 2, with
    Spearman's rho.

    Returns:
        the coefficient; None for fewer than two ratings or items, or if all ratings are constant.
    """
    raters, items = len(ratings), len(ratings[0]) if ratings else 0
    if raters < 2 or items < 2:
        return None
    ranks = [compute_average_ranks(rating) for rating in ratings]
    sums = [sum(column) for column in zip(*ranks, strict=True)]
    mean = sum(sums) / items
    ties = sum(n**3 - n for rating in ratings for n in Counter(rating).values())
    largest = raters**2 * (items**3 - items) - raters * ties
    return 12 * sum((total - mean) ** 2 for total in sums) / largest if largest else None


def compute_average_ranks(rating: Sequence[float]) -> list[float]:
    """Return the rank of each value, 1 for the lowest value. Equal values share the mean of their ranks."""
    ranks = group_pairs((value, rank) for rank, value in enumerate(sorted(rating), 1))
    return [sum(ranks[value]) / len(ranks[value]) for value in rating]


def count_items_best_in_both(
    first_ratings: Sequence[float], second_ratings: Sequence[float], best_count: int
) -> int:
    """Return the number of items that are among the best ``best_count`` items in both ratings.

    Of items with equal ratings, earlier items are better.
    """
    best = [
        sorted(range(len(rating)), key=lambda i: (-rating[i], i))[:best_count]
        for rating in (first_ratings, second_ratings)
    ]
    return len(set(best[0]) & set(best[1]))


def correct_p_values(p_values: Sequence[float]) -> list[float]:
    """Return p values in the given order, after Holm's correction for the number of tests."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected = [0.0] * len(p_values)
    largest = 0.0
    for done, index in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - done) * p_values[index]))
        corrected[index] = largest
    return corrected


def compute_variance_shares_of_rows_columns_rest(
    cells: Sequence[Sequence[float]],
) -> tuple[float, float, float] | None:
    """Return the shares (0 to 1) of a table's variance that are due to rows, to columns, and to neither.

    This is a two-way analysis without replication. The result is None if nothing varies.
    """
    rows, columns = len(cells), len(cells[0])
    mean = sum(map(sum, cells)) / (rows * columns)
    of_rows = columns * sum((sum(row) / columns - mean) ** 2 for row in cells)
    of_columns = rows * sum((sum(column) / rows - mean) ** 2 for column in zip(*cells, strict=True))
    whole = sum((cell - mean) ** 2 for row in cells for cell in row)
    if whole < _ROUNDING:
        return None
    return of_rows / whole, of_columns / whole, max(0.0, 1 - (of_rows + of_columns) / whole)


def _get_sign(number: float) -> int:
    return (number > 0) - (number < 0)


@dataclass(frozen=True, slots=True)
class _RunsByPromptAndModel:
    """A run for each pair of a set of prompts and a model, limited to the tasks that all runs share.

    Attributes:
        metric: name of the metric.
        prompts: names of the prompts, in the order of the runs.
        models: names of the models, in the order of the runs.
        records: (prompt, model) -> stored verdicts on answers; all entries have equal tasks in equal order.
    """

    metric: str
    prompts: tuple[str, ...]
    models: tuple[str, ...]
    records: Mapping[tuple[str, str], Sequence[Record]]

    def list_task_contributions_to_metric(self, prompt: str, model: str) -> TaskRateContributions:
        records = self.records[prompt, model]
        return make_contributions_by_metric(records, records[0].ability)[self.metric]

    @property
    def task_count(self) -> int:
        return len(next(iter(self.records.values())))

    def compute_metric(self, prompt: str, model: str) -> float:
        """Return the metric of one prompt and model in percent; 0 if no task counts for the metric."""
        return (
            compute_rate(case.share for case in self.list_task_contributions_to_metric(prompt, model)).percent
            or 0.0
        )

    def compute_metrics_of_model(self, model: str) -> list[float]:
        """Return the metric of one model with each prompt, in percent, in the order of prompts."""
        return [self.compute_metric(prompt, model) for prompt in self.prompts]


def _group_runs_by_prompt_and_model(
    runs: Sequence[tuple[str, Sequence[Record]]], metric: str
) -> _RunsByPromptAndModel:
    """Return runs on the same ability and benchmark, scored by the same rules, by their prompts and models.

    Raises:
        InputError: a model lacks a prompt that another model has, there are fewer than two prompts, or no
            task is in all runs.
    """
    prompts = tuple(dict.fromkeys(name for name, _ in runs))
    models = tuple(dict.fromkeys(records[0].model for _, records in runs))
    by_cell = {(name, records[0].model): records for name, records in runs}
    if len(prompts) < 2:
        raise InputError(f"expected runs with two prompts or more, found {prompts[0]} alone")
    for prompt in prompts:
        for model in models:
            if (prompt, model) not in by_cell:
                raise InputError(
                    f"{model} has no run with the prompts {prompt}; add its records, or leave out all runs "
                    "with these prompts"
                )
    scored = {
        cell: {record.task_id: record for record in records if record.verdict.excluded is None}
        for cell, records in by_cell.items()
    }
    first = next(iter(scored.values()))
    tasks = [task for task in first if all(task in records for records in scored.values())]
    if not tasks:
        raise InputError("no task is in all runs; give the records of runs on the same tasks")
    shared = {cell: [records[task] for task in tasks] for cell, records in scored.items()}
    return _RunsByPromptAndModel(metric, prompts, models, shared)


def make_prompt_tables(
    runs: Sequence[tuple[str, Sequence[Record]]], metric: str, reference_prompts: str | None = None
) -> list[Table]:
    """Return tables that compare prompts in runs on the same ability and benchmark, scored by the same rules.

    Args:
        runs: pairs of a name of prompts and a run's records; each run has one model.
        metric: name of the metric to compare, such as ``task_success``.
        reference_prompts: the prompts whose metric is subtracted from that of others; the first if None.

    Raises:
        InputError: models have runs with different prompts, only one set of prompts is used, no task is in
            all runs, or no run has the prompts `reference_prompts`.
    """
    matrix = _group_runs_by_prompt_and_model(runs, metric)
    base = reference_prompts or matrix.prompts[0]
    if base not in matrix.prompts:
        raise InputError(f"reference={base}: expected one of {', '.join(matrix.prompts)}")
    top = min(BEST_PROMPTS, len(matrix.prompts))
    return [
        _make_metric_by_prompt_and_model_table(matrix),
        _make_prompt_ranking_agreement_table(matrix, top),
        _make_variance_table(matrix),
        _make_gains_table(matrix, base),
    ]


@collect_rows_in_table("prompts", ("prompt", "answered_by", "value", "format_errors"))
def _make_metric_by_prompt_and_model_table(matrix: _RunsByPromptAndModel) -> Iterator[Row]:
    """{matrix.metric} by prompt and model.

    {matrix.metric} in percent, of the {matrix.task_count} tasks that all runs have scored answers to;
    `format_errors`: share of answers that cannot be read, in percent. Intervals treat all tasks of one
    name as one unit, because similar tasks share a name.
    """
    for prompt, model in product(matrix.prompts, matrix.models):
        records = matrix.records[prompt, model]
        unreadable = [find_answer_outcome(record) is AnswerOutcome.PARSING for record in records]
        yield (
            prompt,
            model,
            Estimate.from_task_rate_contributions(matrix.list_task_contributions_to_metric(prompt, model)),
            estimate_share(records, unreadable),
        )


@collect_rows_in_table("prompt_agreement", ("one", "other", "tau", "shared_top", "concordance"))
def _make_prompt_ranking_agreement_table(
    matrix: _RunsByPromptAndModel, top: int, draws: int = DRAWS
) -> Iterator[Row]:
    """Do models agree on which prompts are better?

    `tau`: Kendall's tau-b of the order of prompts in two models (1 the same, -1 the reverse); `shared_top`:
    number of prompts among the best {top} of both; `concordance`: Kendall's W of all models (0 none, 1 the
    same order). Intervals are percentiles of {draws} draws of task names. They show how far the measured
    agreement depends on these tasks. They do not show the agreement of the true orders: if prompts are
    almost equally good, chance decides the measured order. Cells are empty if a model scores equally with all
    prompts.
    """
    columns = {model: matrix.compute_metrics_of_model(model) for model in matrix.models}
    drawn = list(_draw_bootstrap_metrics_by_model(matrix, draws))
    for first, second in combinations(matrix.models, 2):
        tau = compute_kendall_tau_b(columns[first], columns[second])
        again = [compute_kendall_tau_b(draw[first], draw[second]) for draw in drawn]
        shared = count_items_best_in_both(columns[first], columns[second], top)
        yield (first, second, _make_bootstrap_estimate(tau, again), shared, None)
    if len(matrix.models) > 1:
        concordance = compute_kendall_w(list(columns.values()))
        again = [compute_kendall_w(list(draw.values())) for draw in drawn]
        yield (ALL, None, Estimate(None), None, _make_bootstrap_estimate(concordance, again))


def _draw_bootstrap_metrics_by_model(
    matrix: _RunsByPromptAndModel, draws: int
) -> Iterator[dict[str, list[float]]]:
    """Yield a mapping for each bootstrap draw of task names: model -> its metric with each prompt.

    Task names are drawn with replacement, and all runs use the same drawn names.
    """
    name_by_task = {r.task_id: find_task_name(r) for r in next(iter(matrix.records.values()))}
    names = list(dict.fromkeys(name_by_task.values()))
    sums: dict[tuple[str, str], dict[str, Rate]] = {}
    for cell in matrix.records:
        of_names = group_pairs(
            (name_by_task[case.task], case.share) for case in matrix.list_task_contributions_to_metric(*cell)
        )
        sums[cell] = {name: compute_rate(of_names.get(name, ())) for name in names}
    generator = random.Random(SEED)  # noqa: S311 - statistics, not secrets
    for _ in range(draws):
        draw = generator.choices(names, k=len(names))
        yield {
            model: [
                _compute_percent_of_bootstrap_draw(sums[prompt, model], draw) for prompt in matrix.prompts
            ]
            for model in matrix.models
        }


def _compute_percent_of_bootstrap_draw(
    rate_by_task_name: Mapping[str, Rate], drawn_task_names: Sequence[str]
) -> float:
    numerator = sum(rate_by_task_name[name].numerator for name in drawn_task_names)
    return (
        Rate(numerator, sum(rate_by_task_name[name].denominator for name in drawn_task_names)).percent or 0.0
    )


def _make_bootstrap_estimate(value: float | None, sampled_values: Sequence[float | None]) -> Estimate:
    """Return the value with an interval from percentiles of sampled values.

    There is no interval if a sample has no value.
    """
    values = sorted(drawn for drawn in sampled_values if drawn is not None)
    if value is None or len(values) < len(sampled_values):
        return Estimate(value)
    low, high = (values[math.floor(share * (len(values) - 1))] for share in (0.025, 0.975))
    return Estimate(value, low, high)


@collect_rows_in_table("prompt_variance", ("part", "share"))
def _make_variance_table(matrix: _RunsByPromptAndModel) -> Iterable[Row]:
    """Where the variance of the matrix lies.

    Shares of the variance of the cells, by a two-way analysis without replication: between models, between
    prompts, and the rest (interaction and chance). Empty if nothing varies.
    """
    shares = compute_variance_shares_of_rows_columns_rest(
        [matrix.compute_metrics_of_model(model) for model in matrix.models]
    )
    return zip(("model", "prompt", "rest"), shares or (None, None, None), strict=True)


@collect_rows_in_table("prompt_gains", ("answered_by", "prompt", "best", "gain", "p", "p_holm"))
def _make_gains_table(matrix: _RunsByPromptAndModel, reference: str) -> Iterator[Row]:
    """Gains over {reference}.

    Difference in {matrix.metric} to the run with the prompts {reference} on the same tasks, in percentage
    points. Tasks with the same name, which are similar, count as one unit. `p` is from a test that exchanges
    the answers of the two runs at random. `p_holm` is corrected for the number of prompts, because the best
    of many prompts gains something by chance alone.
    """
    others = [prompt for prompt in matrix.prompts if prompt != reference]
    for model in matrix.models:
        pairs = [(matrix.records[reference, model], matrix.records[prompt, model]) for prompt in others]
        differences = [compare_runs(*pair).differences[matrix.metric] for pair in pairs]
        corrected = correct_p_values([1.0 if gain.p_value is None else gain.p_value for gain in differences])
        values = matrix.compute_metrics_of_model(model)
        best = matrix.prompts[values.index(max(values))]
        for prompt, difference, adjusted in zip(others, differences, corrected, strict=True):
            certainty = difference.certainty
            bounds = (None, None) if certainty is None else certainty.interval
            gain = Estimate(difference.percentage_points, *bounds)
            yield (model, prompt, prompt == best, gain, difference.p_value, adjusted)


class _PromptAnalysisOptions(Options):
    """How prompts are compared.

    Attributes:
        metric: A metric of the ability's main table; its first if not given.
        reference: The prompts from which gains are measured; the first if not given.
    """

    metric: str | None = None
    reference: str | None = None


def _analyze_prompts(records: StudyRecords, chosen: _PromptAnalysisOptions) -> Iterator[Analysis]:
    """Compare runs that differ only in their models and prompts.

    Raises:
        InputError: no runs differ in their prompts, or a model lacks a run that another model has.
    """
    groups = _group_runs_by_suite(records.read_runs())
    several = {
        name: runs
        for name, runs in groups.items()
        if len({_find_prompt_name_of_run(run) for run in runs}) > 1
    }
    for name in [name for name in groups if several and name not in several]:
        records.note(f"left out, because all its runs have the same prompts: {name}")
    for suite, runs in (several or groups).items():
        named = [(_find_prompt_name_of_run(run), run) for run in runs]
        metric = choose_metric(runs[0].key.ability, chosen.metric)
        tables = make_prompt_tables([(name, run.records) for name, run in named], metric, chosen.reference)
        yield Analysis(
            tables,
            _draw_metric_by_prompt_and_model_figures(tables[0], metric, suite),
            folder=to_file_name(suite),
            facts={
                "suite": suite,
                "prompts": list(dict.fromkeys(name for name, _ in named)),
                "models": list(dict.fromkeys(run.key.model for _, run in named)),
            },
        )


def _draw_metric_by_prompt_and_model_figures(metric_table: Table, metric: str, suite: str) -> Figures:
    label = f"{metric}, percent"
    figure = draw_rate_matrix(
        metric_table.row_dicts(),
        ("prompt",),
        "value",
        label,
        other_axis_column="answered_by",
        shows_zero_rates=True,
    )
    if figure is not None:
        add_title(figure, suite.replace("-", ", "))
    yield "prompts", figure
    models = list(dict.fromkeys(str(row["answered_by"]) for row in metric_table.row_dicts()))
    for model in models if len(models) > 1 else ():
        ordered = sort_prompt_rows(metric_table, model)
        figure = draw_rate_matrix(
            ordered, ("prompt",), "value", label, other_axis_column="answered_by", shows_zero_rates=True
        )
        if figure is not None:
            add_title(figure, f"{suite.replace('-', ', ')}: best prompts of {clip_label(model)} first")
        yield f"prompts-by-{to_file_name(model)}", figure


def sort_prompt_rows(metric_table: Table, model: str) -> list[dict[str, Cell]]:
    """Return the rows of a table of prompts, sorted by a model's result with each prompt, best first."""
    rows = metric_table.row_dicts()
    values = {row["prompt"]: get_value_of_cell(row["value"]) for row in rows if row["answered_by"] == model}
    return sorted(rows, key=lambda row: -values[row["prompt"]])


def _find_prompt_name_of_run(run: Run) -> str:
    choice = run.records[0].settings_by_study.get(STUDY)
    return PLAIN if choice is None else str(choice.options["prompt_name"])


def _group_runs_by_suite(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """Return groups of runs that differ only in their models and prompts."""
    suites: dict[str, list[Run]] = {}
    for run in runs:
        experiment = run.key.experiment
        rest = None if experiment is None else experiment.drop_options_of_study(STUDY)
        labels = [run.key.suite.suite_name_for_file_names, *([] if rest is None else [rest.label])]
        suites.setdefault("-".join(labels), []).append(run)
    return suites


PROMPTS = Study(
    "prompts",
    "Runs of models with several prompts (prompts.name) side by side, suite by suite.",
    choices=_PromptAnalysisOptions,
    analyze=_analyze_prompts,
)
