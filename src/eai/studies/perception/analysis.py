"""Perception: what errors in the perceived scene cost, by their number, their kind and the facts lost.

The horizontal axis is always the realised rate, counted in what was perceived, never what a channel was asked
for and never the outcome. Tasks recur in runs, and near copies in tasks; the unit of every interval is the
name of the task. The cost of errors stands beside the same tasks without any, where there is such a run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

from eai.abilities.record import Perceived, Record
from eai.abilities.verdict import Share
from eai.errors import InputError
from eai.results.certainty import Case, Cases
from eai.results.rate import Rate
from eai.results.summary import cases_of
from eai.results.table import Estimate, Row, Table, table_of
from eai.studies.perception.declaration import perception_shares

PLAIN = "text"
"""The name of a run whose questions tell of the scene as it is."""

BOUNDS = (0, 5, 10, 20, 40, 100)
"""The upper bounds of the groups of predicate error rates, in percent."""

_RATES = ("predicate_error", "missing", "misplaced", "unnecessary", "object_error", "unseen")
_LAST = 1000.0
_COSTS = ("cases", "value", "without_errors", "cost")


@dataclass(frozen=True, slots=True)
class _Seen:
    """One task in one run: what was perceived, and what the answer adds to the metric."""

    perceived: Perceived
    case: Case

    @property
    def rate(self) -> float:
        """The predicate error rate in percent; 0 where nothing is described."""
        return Rate(*perception_shares(self.perceived)["predicate_error"]).percent or 0.0

    @property
    def kinds(self) -> frozenset[str]:
        """The kinds of error in it; that facts about unseen objects are missing is no kind of its own."""
        counts = {
            "missing": 0 if self.perceived.unseen else self.perceived.missing,
            "misplaced": self.perceived.misplaced,
            "unnecessary": self.perceived.unnecessary,
            "object hallucination": self.perceived.invented_names,
            "unseen object": self.perceived.unseen,
        }
        return frozenset([kind for kind, count in counts.items() if count])

    @property
    def lost(self) -> frozenset[str]:
        """The predicates of which described facts are lost or misplaced."""
        return frozenset([name for name, counts in self.perceived.predicates.items() if counts[2]])

    def with_share(self, share: Share) -> Case:
        """The case of the task in another rate."""
        return self.case._replace(share=share)


Group: TypeAlias = Sequence[_Seen]


@dataclass(frozen=True)
class _Runs:
    """The runs of one model on one suite that show the scene in several ways.

    Attributes:
        metric: one of the ability's.
        runs: the records of each way, by its name; `PLAIN` among them, where there is such a run.
    """

    metric: str
    runs: dict[str, Sequence[Record]]

    @cached_property
    def seen(self) -> list[_Seen]:
        """All tasks in all runs of which it is known what was perceived."""
        return [each for name in self.runs for each in self.of_run(name)]

    def of_run(self, name: str) -> list[_Seen]:
        """The tasks of a run of which it is known what was perceived."""
        cases = {case.task: case for case in self.cases(name)}
        return [
            _Seen(record.perceived, cases[record.task_id])
            for record in self.runs[name]
            if record.perceived is not None and record.task_id in cases
        ]

    def cases(self, name: str) -> Cases:
        """The cases that the tasks of a run add to the metric."""
        records = self.runs[name]
        return cases_of(records, records[0].ability).get(self.metric, ())

    @cached_property
    def plain(self) -> dict[str, Case]:
        """The case of each task where the question shows the scene as it is."""
        return {case.task: case for case in self.cases(PLAIN)} if PLAIN in self.runs else {}

    def costs(self, group: Group) -> Row:
        """The cells on a group of cases: `_COSTS`."""
        cases = [each.case for each in group]
        without = [self.plain[case.task] for case in cases if case.task in self.plain]
        if not without or len(without) < len(cases):
            return (len(cases), Estimate.of(cases), Estimate(None), Estimate(None))
        cost = Estimate.of_difference(cases, without)
        return (len(cases), Estimate.of(cases), Estimate.of(without), cost)


def perception_tables(runs: Sequence[Sequence[Record]], metric: str) -> list[Table]:
    """The tables of the runs of one model and suite.

    Args:
        runs: the records of each.
        metric: one of the ability's.

    Raises:
        InputError: none of the runs says what was perceived.
    """
    found = _Runs(metric, {_name(records): records for records in runs})
    if not found.seen:
        raise InputError(
            "expected records that say what was perceived; eai run --with perception.scene=noisy does"
        )
    return [_by_run(found), _by_rate(found), _by_kind(found), _by_predicate(found)]


def _name(records: Sequence[Record]) -> str:
    experiment = records[0].experiment
    return PLAIN if experiment is None or experiment.scene is None else experiment.scene


@table_of("perception_runs", ("scene", *_RATES, "value"))
def _by_run(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by how the scene is shown.

    A row a run: realised error rates in percent, then {runs.metric}. `predicate_error`: facts missing or
    misplaced, of those described; `object_error`: names that the scene has not, of all names; `missing`,
    `misplaced`, `unnecessary`: facts of these kinds, of those described, of described relations, of perceived
    ones; `unseen`: objects not named, of all. Empty where a question does not tell of a scene graph. Sorted
    by `predicate_error`.
    """
    rates = {name: _rates(runs.of_run(name)) for name in runs.runs}
    places = {name: -1.0 if each[0].value is None else each[0].value for name, each in rates.items()}
    for name in sorted(rates, key=lambda name: (places[name], name)):
        yield (name, *rates[name], Estimate.of(runs.cases(name)))


def _rates(seen: Group) -> list[Estimate]:
    """The error rates of a run; their intervals are of tasks that differ in how much can be missed."""
    if not seen:
        return [Estimate(None)] * len(_RATES)
    shares = [(each, perception_shares(each.perceived)) for each in seen]
    return [Estimate.of([each.with_share(of_task[name]) for each, of_task in shares]) for name in _RATES]


@table_of("perception_rates", ("above", "up_to", *_COSTS))
def _by_rate(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by predicate error rate.

    A row a group of answers, of all runs, by the predicate error rate of their own scene graph: 0, or above
    the first bound up to the second, in percent. Tasks of few facts are more often in the outer groups:
    `without_errors` is {runs.metric} of the same tasks told as they are, and `cost` the difference in
    percentage points. `cases` counts a task once for each run. The group of 0 may have unnecessary facts and
    unseen objects that nothing is said of.
    """
    for low, high in [(0.0, 0.0), *pairwise(BOUNDS)]:
        group = [each for each in runs.seen if each.rate == high == 0 or low < each.rate <= high]
        if group:
            yield (low, high, *runs.costs(group))


@table_of("perception_kinds", ("kind", *_COSTS))
def _by_kind(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by kind of error.

    A row of answers whose scene graphs have errors of this kind and no other, however many. That facts about
    an unseen object are missing belongs to `unseen object`.
    """
    kinds = sorted({kind for each in runs.seen for kind in each.kinds})
    groups = {"none": [each for each in runs.seen if not each.kinds]}
    groups |= {kind: [each for each in runs.seen if each.kinds == {kind}] for kind in kinds}
    groups["several"] = [each for each in runs.seen if len(each.kinds) > 1]
    yield from [(kind, *runs.costs(group)) for kind, group in groups.items() if group]


@table_of("perception_predicates", ("predicate", "lost", "all_cases", *_COSTS))
def _by_predicate(runs: _Runs) -> Iterable[Row]:
    """Which facts cost most when they are lost.

    A row a predicate: of its described facts how many were lost or misplaced (`lost`, in percent), then
    {runs.metric} of the answers in which facts of this predicate and of no other are lost, and nothing else
    is wrong. `all_cases`: answers in which such facts are lost, whatever else is. Sorted by cost.
    """
    names = sorted({name for each in runs.seen for name in each.lost})
    return sorted([_predicate_row(name, runs) for name in names], key=_by_cost)


def _predicate_row(name: str, runs: _Runs) -> Row:
    having = [each for each in runs.seen if name in each.perceived.predicates]
    lost = [each for each in having if name in each.lost]
    alone = [each for each in lost if each.lost == {name} and each.kinds <= {"missing", "misplaced"}]
    counts = [each.perceived.predicates[name] for each in having]
    shares = [Share(gone, right + gone) for right, _, gone in counts]
    lost_share = Estimate.of([each.with_share(share) for each, share in zip(having, shares, strict=True)])
    return (name, lost_share, len(lost), *runs.costs(alone))


def _by_cost(row: Row) -> tuple[float, str]:
    """The costliest first; then by value, where there is nothing to compare with; without any case last."""
    for place, sign in ((6, -1), (4, 1)):
        cell = row[place]
        if isinstance(cell, Estimate) and cell.value is not None:
            return (sign * cell.value, str(row[0]))
    return (_LAST, str(row[0]))
