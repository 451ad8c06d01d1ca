"""Analyze the quality of annotations, as rated by people (paper, "Annotation Quality").

A rater gives a task's annotation 1 to 5 points for each attribute. Ratings come in a CSV file with the
columns task, rater, attribute and score. The agreement of raters is measured by the spread of their ratings
of one task, and by Krippendorff's alpha.
"""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, pvariance
from typing import TYPE_CHECKING, TypeAlias, cast

from eai.base.errors import InputError
from eai.base.files import decode_text, read_content
from eai.base.grouping import group_pairs
from eai.results.plots import ACCENT, INK, clip_label, make_figure
from eai.results.table import Row, Table, collect_rows_in_table
from eai.studies.study import Analysis, Figures, Study
from eai.tasks.options import Options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.base.json_value import Json
    from eai.studies.records import StudyRecords


RatingsByTask: TypeAlias = Sequence[Sequence[float]]
"""People's ratings of one attribute of annotations: for each rated task, one rating by each rater."""


COLUMNS = ("task", "rater", "attribute", "score")

SCORES = (1, 2, 3, 4, 5)

PAPER_NOTE = (
    "The paper has action accuracy 3.73 (weighted MSE 0.41), action coverage 4.07 (1.84) and human "
    "preference 4.27 (0.81); its ratings, seemingly 15 of each, are not published. It calls their "
    "variability low. Ratings drawn at random from 1 to 5 have a weighted MSE of 1 where tasks are rated "
    "twice, and of 1.25 where one is rated four times and two twice, which these figures allow: 1.84 is more."
)
"""The paper's figures on people's ratings of its annotations, and how to read them."""


def compute_mse_around_task_means(ratings_by_task: RatingsByTask) -> float | None:
    """Return the mean squared distance of people's ratings of annotations from the mean rating of the task.

    Each rating has the same weight. Tasks with one rating are left out. The result is None if no task has two
    ratings.
    """
    repeated = [unit for unit in ratings_by_task if len(unit) > 1]
    number = sum(map(len, repeated))
    return sum(len(unit) * pvariance(unit) for unit in repeated) / number if number else None


def compute_krippendorff_alpha(units: RatingsByTask) -> float | None:
    """Return Krippendorff's alpha, the agreement of raters, for ratings on an interval scale.

    1 is perfect agreement. 0 is the agreement of raters who draw from all ratings at random. A negative value
    is less agreement than that. Raters may leave out tasks. (K. Krippendorff, Content Analysis, chapter
    "Reliability": the ratio of observed to expected squared differences.)

    Returns:
        alpha, or None if no task was rated twice or all ratings of such tasks are equal.
    """
    pairable = [unit for unit in units if len(unit) > 1]
    ratings = [rating for unit in pairable for rating in unit]
    if not ratings or len(set(ratings)) == 1:
        return None
    number = len(ratings)
    # The squared differences of all ordered pairs of n ratings have the sum 2 n^2 variance. Each of the
    # n ratings of a task is compared with n - 1 other ratings, so alpha divides the sum by n - 1.
    observed = sum(2 * len(unit) ** 2 * pvariance(unit) / (len(unit) - 1) for unit in pairable) / number
    expected = 2 * number * pvariance(ratings) / (number - 1)
    return 1 - observed / expected


@dataclass(frozen=True, slots=True)
class _HumanRatingOfAnnotation:
    task: str
    rater: str
    attribute: str
    score: int


def read_ratings(path: Path) -> tuple[_HumanRatingOfAnnotation, ...]:
    """Read people's ratings of annotations from a CSV file, in order.

    Raises:
        InputError: the file cannot be read or is malformed. The message names the line and the column.
    """
    text = decode_text(path, read_content(path))
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        return tuple(_parse_ratings(path, ((rows.line_num, row) for row in rows)))
    except csv.Error as error:
        raise InputError(f"{path}: line {rows.line_num}: {error}") from error


@collect_rows_in_table(
    "annotations",
    (
        *("attribute", "ratings", "tasks", "raters", "repeated"),
        *("mean", "weighted_mse", "spread", "alpha"),
    ),
)
def summarize_ratings(ratings: Iterable[_HumanRatingOfAnnotation]) -> Iterator[Row]:
    """Ratings of annotations by attribute.

    Ratings are 1 to 5. `repeated`: number of tasks rated more than once. Only these tasks count in the last
    three columns, which are empty without any. `weighted_mse`: mean squared distance of a rating from the
    mean of its task. `spread`: square root of `weighted_mse`, in points. `alpha`: Krippendorff's alpha for an
    interval scale; 1 is perfect agreement, 0 is chance.
    """
    for attribute, given in group_pairs((rating.attribute, rating) for rating in ratings).items():
        units = tuple(group_pairs((rating.task, rating.score) for rating in given).values())
        raters, repeated = {rating.rater for rating in given}, sum(len(unit) > 1 for unit in units)
        mean, distance = fmean(rating.score for rating in given), compute_mse_around_task_means(units)
        spread = None if distance is None else math.sqrt(distance)
        counts = (len(given), len(units), len(raters), repeated)
        yield (attribute, *counts, mean, distance, spread, compute_krippendorff_alpha(units))


@collect_rows_in_table("annotation_scores", ("attribute", "score", "ratings"))
def count_ratings_by_score(ratings: Sequence[_HumanRatingOfAnnotation]) -> Iterator[Row]:
    """Number of times that each score was given.

    The table has a row for each attribute and score.
    """
    counts = Counter((rating.attribute, rating.score) for rating in ratings)
    for attribute in dict.fromkeys(rating.attribute for rating in ratings):
        yield from [(attribute, score, counts[attribute, score]) for score in SCORES]


def _parse_ratings(path: Path, lines: Iterator[tuple[int, list[str]]]) -> Iterator[_HumanRatingOfAnnotation]:
    _, header = next(lines, (1, []))
    names = [name.strip().lower() for name in header]
    for column in COLUMNS:
        if names.count(column) != 1:
            raise InputError(f"{path}: line 1: expected the columns {', '.join(COLUMNS)}, each once")
    seen: dict[tuple[str, str, str], int] = {}
    for line, row in lines:
        if not any(map(str.strip, row)):
            continue
        if len(row) != len(names):
            raise InputError(f"{path}: line {line}: expected {len(names)} columns, found {len(row)}")
        fields = {name: text.strip() for name, text in zip(names, row, strict=True)}
        for column in COLUMNS:
            if not fields[column]:
                raise InputError(f"{path}: line {line}, column {column}: expected a value, found none")
        if fields["score"] not in map(str, SCORES):
            value = fields["score"]
            raise InputError(f"{path}: line {line}, column score: expected 1 to 5, found {value!r}")
        key = (fields["task"], fields["rater"], fields["attribute"])
        if key in seen:
            raise InputError(
                f"{path}: line {line} rates task {key[0]!r}, attribute {key[2]!r}, by rater {key[1]!r}, as "
                f"line {seen[key]} does; keep one of them"
            )
        seen[key] = line
        yield _HumanRatingOfAnnotation(*key, score=int(fields["score"]))
    if not seen:
        raise InputError(f"{path}: line 2: expected ratings, found none")


_FACT_COLUMNS = ("attribute", "ratings", "tasks", "repeated", "mean", "weighted_mse", "alpha")


def _analyze_ratings_file(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    """Analyze one CSV file of people's ratings of annotations. No records are needed."""
    if len(records.paths) > 1:
        raise InputError(f"expected one CSV file of ratings, found {len(records.paths)} paths")
    ratings = read_ratings(records.paths[0])
    tables = [summarize_ratings(ratings), count_ratings_by_score(ratings)]
    rows = tables[0].row_dicts()
    attributes: list[Json] = [{name: cast("Json", row[name]) for name in _FACT_COLUMNS} for row in rows]
    yield Analysis(
        tables,
        _draw_figures(tables),
        [PAPER_NOTE],
        screen_tables=tables[:1],
        facts={"attributes": attributes},
    )


def _draw_figures(tables: Sequence[Table]) -> Figures:
    yield "annotations", draw_rating_histograms(tables)


_PANEL_INCHES = (2.3, 2.0)
_MAX_PANEL_COLUMNS = 3


def draw_rating_histograms(tables: Sequence[Table]) -> Figure:
    """Draw the score histogram of each attribute."""
    attributes, scores = (table.row_dicts() for table in tables)
    columns = min(_MAX_PANEL_COLUMNS, len(attributes))
    rows = -(-len(attributes) // columns)
    figure = make_figure(_PANEL_INCHES[0] * columns, _PANEL_INCHES[1] * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).flatten()
    for panel, attribute in zip(panels, attributes, strict=False):
        name = str(attribute["attribute"])
        counts = {row["score"]: row["ratings"] for row in scores if row["attribute"] == name}
        panel.set_title(clip_label(name))
        panel.bar(list(counts), list(counts.values()), width=0.8, color=ACCENT)
        for score, count in counts.items():
            if count:
                panel.annotate(str(count), (score, count), ha="center", va="bottom", fontsize=6.5, color=INK)
        panel.set_xticks(list(counts))
        panel.set_xlabel(f"mean {attribute['mean']:.2f}, n = {attribute['ratings']}")
    for panel in panels[::columns]:
        panel.set_ylabel("ratings")
        panel.yaxis.get_major_locator().set_params(integer=True)
    for panel in panels[len(attributes) :]:
        panel.set_visible(False)
    return figure


ANNOTATIONS = Study(
    "annotations",
    "People's ratings of annotations, in a CSV file: means, spread of raters, Krippendorff's alpha.",
    analyze=_analyze_ratings_file,
)
