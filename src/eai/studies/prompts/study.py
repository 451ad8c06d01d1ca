"""Prompt variability (paper, appendix on prompts): how much an answer's worth depends on how one asks.

Runs of several models, each with several prompts, on the same tasks make a matrix of one metric. From it: do
models agree on which prompt is best, how much of the variance is the prompt's, and does any prompt gain
something that is more than chance, given that the best of many was picked.
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
from eai.results.certainty import Cases
from eai.results.comparison import compare
from eai.results.plots import add_title, clip_label, draw_matrix, value_of
from eai.results.rate import Rate, rate_of
from eai.results.record import Record
from eai.results.runs import Run
from eai.results.summary import cases_of, outcome_of, share_of
from eai.results.table import Cell, Estimate, Row, Table, make_table
from eai.studies.prompts.choice import STUDY
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, metric_of
from eai.tasks.options import Options

_ROUNDING = 1e-9

PLAIN = "(no name)"
"""The name of the prompts of a run that gives them none."""

TOP = 3

DRAWS = 1000

SEED = 20240901

ALL = "all models"


def kendall_tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Kendall's tau-b of two ratings of the same things: 1 the same order, -1 the reverse.

    Returns:
        None where one of them rates all alike: then there is no order to agree with.
    """
    concordant = ties_first = ties_second = 0
    for (a, b), (c, d) in combinations(zip(first, second, strict=True), 2):
        concordant += _sign(a - c) * _sign(b - d)
        ties_first += a == c
        ties_second += b == d
    pairs = math.comb(len(first), 2)
    scale = (pairs - ties_first) * (pairs - ties_second)
    return concordant / math.sqrt(scale) if scale else None


def kendall_w(ratings: Sequence[Sequence[float]]) -> float | None:
    """Kendall's coefficient of concordance of several ratings of the same things, corrected for ties.

    0 no agreement, 1 the same order; of two ratings it is (1 + Spearman's correlation) / 2.

    Returns:
        None for fewer than two ratings or things, or where all are rated alike.
    """
    raters, things = len(ratings), len(ratings[0]) if ratings else 0
    if raters < 2 or things < 2:
        return None
    ranks = [average_ranks(rating) for rating in ratings]
    sums = [sum(column) for column in zip(*ranks, strict=True)]
    mean = sum(sums) / things
    ties = sum(n**3 - n for rating in ratings for n in Counter(rating).values())
    largest = raters**2 * (things**3 - things) - raters * ties
    return 12 * sum((each - mean) ** 2 for each in sums) / largest if largest else None


def average_ranks(rating: Sequence[float]) -> list[float]:
    """The rank of each thing from 1, the lowest first; equal ones share the mean of theirs."""
    places = group_pairs((value, rank) for rank, value in enumerate(sorted(rating), 1))
    return [sum(places[value]) / len(places[value]) for value in rating]


def shared_at_top(first: Sequence[float], second: Sequence[float], most: int) -> int:
    """How many things are among the best in both; of equal ones the earlier counts as better."""
    best = [sorted(range(len(each)), key=lambda i: (-each[i], i))[:most] for each in (first, second)]
    return len(set(best[0]) & set(best[1]))


def holm(p_values: Sequence[float]) -> list[float]:
    """The p values after Holm's correction for their number, in the same order."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected = [0.0] * len(p_values)
    largest = 0.0
    for done, place in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - done) * p_values[place]))
        corrected[place] = largest
    return corrected


def two_way_shares(cells: Sequence[Sequence[float]]) -> tuple[float, float, float] | None:
    """How much of the variance of a table is its rows', its columns' and the rest's, as shares of 1.

    Two-way, without replication; None where nothing varies.
    """
    rows, columns = len(cells), len(cells[0])
    mean = sum(map(sum, cells)) / (rows * columns)
    of_rows = columns * sum((sum(row) / columns - mean) ** 2 for row in cells)
    of_columns = rows * sum((sum(column) / rows - mean) ** 2 for column in zip(*cells, strict=True))
    whole = sum((cell - mean) ** 2 for row in cells for cell in row)
    if whole < _ROUNDING:
        return None
    return of_rows / whole, of_columns / whole, max(0.0, 1 - (of_rows + of_columns) / whole)


def _sign(number: float) -> int:
    return (number > 0) - (number < 0)


@dataclass(frozen=True, slots=True)
class _Matrix:
    """One metric of runs of each model with each prompt, on the tasks that all of them have.

    Attributes:
        metric: its name.
        prompts: in the order of the runs.
        models: likewise.
        records: prompt and model -> the scored records, of the same tasks in the same order.
    """

    metric: str
    prompts: tuple[str, ...]
    models: tuple[str, ...]
    records: Mapping[tuple[str, str], Sequence[Record]]

    def cases(self, prompt: str, model: str) -> Cases:
        """The cases that tasks add to a cell."""
        records = self.records[prompt, model]
        return cases_of(records, records[0].ability)[self.metric]

    @property
    def tasks(self) -> int:
        """How many tasks all runs have."""
        return len(next(iter(self.records.values())))

    def value(self, prompt: str, model: str) -> float:
        """A cell in percent; 0 where the metric is of nothing."""
        return rate_of(case.share for case in self.cases(prompt, model)).percent or 0.0

    def column(self, model: str) -> list[float]:
        """The cells of a model, by prompt."""
        return [self.value(prompt, model) for prompt in self.prompts]


def _matrix_of(runs: Sequence[tuple[str, Sequence[Record]]], metric: str) -> _Matrix:
    """The matrix of runs of one suite and protocol.

    Raises:
        InputError: a model lacks a prompt that another has, there are fewer than two prompts, or no task is
            in all runs.
    """
    prompts = tuple(dict.fromkeys(name for name, _ in runs))
    models = tuple(dict.fromkeys(records[0].model for _, records in runs))
    found = {(name, records[0].model): records for name, records in runs}
    if len(prompts) < 2:
        raise InputError(f"expected runs with two prompts or more, found {prompts[0]} alone")
    for prompt in prompts:
        for model in models:
            if (prompt, model) not in found:
                raise InputError(f"{model} has no run with the prompts {prompt}")
    scored = {
        place: {record.task_id: record for record in records if record.verdict.excluded is None}
        for place, records in found.items()
    }
    first = next(iter(scored.values()))
    tasks = [task for task in first if all(task in records for records in scored.values())]
    if not tasks:
        raise InputError("expected runs on the same tasks, found no task that all of them have")
    shared = {place: [records[task] for task in tasks] for place, records in scored.items()}
    return _Matrix(metric, prompts, models, shared)


def prompt_tables(
    runs: Sequence[tuple[str, Sequence[Record]]], metric: str, reference: str | None = None
) -> list[Table]:
    """The tables of runs of one suite and protocol.

    Args:
        runs: the name of the prompts, and the records of one model.
        metric: one of the ability's.
        reference: the prompts that gains are measured from; the first if None.

    Raises:
        InputError: the runs make no matrix, or there are no such prompts.
    """
    matrix = _matrix_of(runs, metric)
    base = reference or matrix.prompts[0]
    if base not in matrix.prompts:
        raise InputError(f"reference={base}: expected one of {', '.join(matrix.prompts)}")
    top = min(TOP, len(matrix.prompts))
    return [_cells(matrix), _agreement(matrix, top), _variance(matrix), _gains(matrix, base)]


@make_table("prompts", ("prompt", "answered_by", "value", "format_errors"))
def _cells(matrix: _Matrix) -> Iterator[Row]:
    """{matrix.metric} by prompt and model.

    {matrix.metric} in percent, of the {matrix.tasks} tasks that all runs have scored answers to;
    `format_errors`: share of answers that cannot be read, in percent. Intervals have the names of tasks as
    units.
    """
    for prompt, model in product(matrix.prompts, matrix.models):
        records = matrix.records[prompt, model]
        unreadable = [outcome_of(record) is AnswerOutcome.PARSING for record in records]
        yield (prompt, model, Estimate.from_cases(matrix.cases(prompt, model)), share_of(records, unreadable))


@make_table("prompt_agreement", ("one", "other", "tau", "shared_top", "concordance"))
def _agreement(matrix: _Matrix, top: int, draws: int = DRAWS) -> Iterator[Row]:
    """Do models agree on which prompts are better?

    `tau`: Kendall's tau-b of the prompts' order in two models (1 the same, -1 the reverse); `shared_top`: how
    many of the best {top} are so in both; `concordance`: Kendall's W of all models (0 none, 1 the same
    order). Intervals are percentiles of {draws} draws of task names: how far the measured agreement rests on
    these tasks. They are not where the agreement of the true orders is: chance makes it look lower where
    prompts are close. Empty where all prompts are equal in a model.
    """
    columns = {model: matrix.column(model) for model in matrix.models}
    drawn = list(_drawn(matrix, draws))
    for first, second in combinations(matrix.models, 2):
        tau = kendall_tau_b(columns[first], columns[second])
        again = [kendall_tau_b(each[first], each[second]) for each in drawn]
        shared = shared_at_top(columns[first], columns[second], top)
        yield (first, second, _interval(tau, again), shared, None)
    if len(matrix.models) > 1:
        concordance = kendall_w(list(columns.values()))
        again = [kendall_w(list(each.values())) for each in drawn]
        yield (ALL, None, Estimate(None), None, _interval(concordance, again))


def _drawn(matrix: _Matrix, draws: int) -> Iterator[dict[str, list[float]]]:
    """The columns of the matrix for names drawn with replacement, the same ones for all runs."""
    sums: dict[tuple[str, str], dict[str, Rate]] = {}
    for place in matrix.records:
        of_names = group_pairs((case.name, case.share) for case in matrix.cases(*place))
        sums[place] = {name: rate_of(shares) for name, shares in of_names.items()}
    names = list(next(iter(sums.values())))
    generator = random.Random(SEED)  # noqa: S311 - statistics, not secrets
    for _ in range(draws):
        draw = generator.choices(names, k=len(names))
        yield {
            model: [_rate(sums[prompt, model], draw) for prompt in matrix.prompts] for model in matrix.models
        }


def _rate(of_names: Mapping[str, Rate], draw: Sequence[str]) -> float:
    numerator = sum(of_names[name].numerator for name in draw)
    return Rate(numerator, sum(of_names[name].denominator for name in draw)).percent or 0.0


def _interval(value: float | None, again: Sequence[float | None]) -> Estimate:
    """The value with percentiles of what draws give; without them where some draws give nothing."""
    known = sorted(each for each in again if each is not None)
    if value is None or len(known) < len(again):
        return Estimate(value)
    low, high = (known[math.floor(share * (len(known) - 1))] for share in (0.025, 0.975))
    return Estimate(value, low, high)


@make_table("prompt_variance", ("part", "share"))
def _variance(matrix: _Matrix) -> Iterable[Row]:
    """Where the variance of the matrix lies.

    Shares of the variance of the cells, two-way without replication: between models, between prompts, and
    what neither explains, which is interaction and chance. Empty where nothing varies.
    """
    shares = two_way_shares([matrix.column(model) for model in matrix.models])
    return zip(("model", "prompt", "rest"), shares or (None, None, None), strict=True)


@make_table("prompt_gains", ("answered_by", "prompt", "best", "gain", "p", "p_holm"))
def _gains(matrix: _Matrix, reference: str) -> Iterator[Row]:
    """Gains over {reference}.

    Percentage points of {matrix.metric} against the prompts {reference}, paired by task, near copies
    together; `p` of a random exchange of the two runs, `p_holm` corrected for the number of prompts: the best
    of many gains something by chance alone.
    """
    others = [prompt for prompt in matrix.prompts if prompt != reference]
    for model in matrix.models:
        pairs = [(matrix.records[reference, model], matrix.records[prompt, model]) for prompt in others]
        found = [compare(*pair).differences[matrix.metric] for pair in pairs]
        corrected = holm([1.0 if each.p_value is None else each.p_value for each in found])
        values = matrix.column(model)
        best = matrix.prompts[values.index(max(values))]
        for prompt, difference, adjusted in zip(others, found, corrected, strict=True):
            certainty = difference.certainty
            bounds = (None, None) if certainty is None else certainty.interval
            gain = Estimate(difference.points, *bounds)
            yield (model, prompt, prompt == best, gain, difference.p_value, adjusted)


class _Choices(Options):
    """How prompts are compared.

    Attributes:
        metric: Which metric of the ability's main table; its first if not given.
        reference: The prompts that gains are measured from; the first if not given.
    """

    metric: str | None = None
    reference: str | None = None


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    """Runs that differ in their model and their prompts alone belong together.

    Raises:
        InputError: no runs differ in their prompts, or a model lacks a run that another one has.
    """
    groups = _by_suite(records.runs())
    several = {name: runs for name, runs in groups.items() if len({_name(run) for run in runs}) > 1}
    for name in groups.keys() - several.keys() if several else ():
        records.note(f"left out, as all its runs have the same prompts: {name}")
    for suite, runs in (several or groups).items():
        named, metric = [(_name(run), run) for run in runs], metric_of(runs[0].key.ability, chosen.metric)
        tables = prompt_tables([(name, run.records) for name, run in named], metric, chosen.reference)
        yield Analysis(
            tables,
            _figures(tables[0], metric, suite),
            folder=to_file_name(suite),
            facts={
                "suite": suite,
                "prompts": list(dict.fromkeys(name for name, _ in named)),
                "models": list(dict.fromkeys(run.key.model for _, run in named)),
            },
        )


def _figures(cells: Table, metric: str, suite: str) -> Figures:
    label = f"{metric}, percent"
    figure = draw_matrix(cells.row_dicts(), ("prompt",), "value", label, across="answered_by", zeros=True)
    if figure is not None:
        add_title(figure, suite.replace("-", ", "))
    yield "prompts", figure
    models = list(dict.fromkeys(str(row["answered_by"]) for row in cells.row_dicts()))
    for model in models if len(models) > 1 else ():
        ordered = ordered_by(cells, model)
        figure = draw_matrix(ordered, ("prompt",), "value", label, across="answered_by", zeros=True)
        if figure is not None:
            add_title(figure, f"{suite.replace('-', ', ')}: best prompts of {clip_label(model)} first")
        yield f"prompts-by-{to_file_name(model)}", figure


def ordered_by(cells: Table, model: str) -> list[dict[str, Cell]]:
    """Return the rows of a table of prompts, first those of the prompts with which a model is best."""
    rows = cells.row_dicts()
    values = {row["prompt"]: value_of(row["value"]) for row in rows if row["answered_by"] == model}
    return sorted(rows, key=lambda row: -values[row["prompt"]])


def _name(run: Run) -> str:
    part = run.records[0].study.get(STUDY)
    return PLAIN if part is None else str(part.options["prompt_name"])


def _by_suite(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """The runs of each suite and protocol that differ in nothing but their model and their prompts."""
    suites: dict[str, list[Run]] = {}
    for run in runs:
        experiment = run.key.experiment
        rest = None if experiment is None else experiment.drop_study(STUDY)
        labels = [run.key.suite.file_name, *([] if rest is None else [rest.label])]
        suites.setdefault("-".join(labels), []).append(run)
    return suites


PROMPTS = Study(
    "prompts",
    "Runs of models with several prompts (prompts.name) side by side, suite by suite.",
    choices=_Choices,
    analyze=_analyze,
)
