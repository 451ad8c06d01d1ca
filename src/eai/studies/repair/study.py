"""Repair: how many edits failed answers are from right ones, of which kinds, and where."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from statistics import median

from eai.abilities.repair import Repair
from eai.base.errors import InputError
from eai.results.lines import MODEL, SUITE
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import outcome_of, share_of
from eai.results.table import Estimate, Row, make_table
from eai.studies.records import Records
from eai.studies.study import Analysis, Study
from eai.tasks.options import Options

_FAR = 5
"""Distances from here on are counted together."""


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    mended = [(run.key, found) for run in records.runs() if (found := list(_mended(run)))]
    mended.sort(key=lambda each: each[0].order)
    tables = [_distances(mended), _edits(mended), _kinds(mended), _causes(mended)]
    if not tables[0].rows:
        raise InputError(
            "no record has a repair; eai score --look-back 20000 puts one into each failed answer"
        )
    yield Analysis(tables, shown=tables[:1])


def _mended(run: Run) -> Iterator[tuple[Record, Repair]]:
    """The failed answers of a run of which a repair is told, each with it."""
    for record in run.records:
        repair = record.verdict.repair
        if repair is not None and repair.at_most != 0:
            yield record, repair


_Mended = Sequence[tuple[RunKey, list[tuple[Record, Repair]]]]


def _share(found: Sequence[tuple[Record, Repair]], counted: Sequence[bool]) -> Estimate:
    return share_of([record for record, _ in found], counted)


@make_table("distances", (*SUITE, MODEL, "failed", "unknown", "exact", "within_2", "one_edit"))
def _distances(mended: _Mended) -> Iterator[Row]:
    """How far failed answers are from right ones.

    Failed answers by the fewest edits (steps inserted, deleted or replaced) that make them right. unknown:
    those of which nothing is known, unreadable ones above all; exact: those whose number is known, within_2:
    whose bounds differ by two at most, one_edit: that one edit mends, in percent of the others.
    """
    for key, answers in mended:
        found = _bounded(answers)
        if not found:
            continue
        near = [r.at_most is not None and r.at_most - r.at_least <= 2 for _, r in found]
        exact = [r.distance is not None for _, r in found]
        single = [r.distance == 1 for _, r in found]
        shares = [_share(found, counted) for counted in (exact, near, single)]
        yield (*key.cells, len(found), len(answers) - len(found), *shares)


def _bounded(answers: Sequence[tuple[Record, Repair]]) -> list[tuple[Record, Repair]]:
    """The answers of whose distance something is known."""
    return [(record, repair) for record, repair in answers if repair.why_null is None]


@make_table("edits", (*SUITE, MODEL, "1", "2", "3", "4", "5+", "ties"))
def _edits(mended: _Mended) -> Iterator[Row]:
    """How many edits it takes.

    Failed answers whose distance is known, by distance. ties: of those at one edit, how many single edits
    make them right, in the median.
    """
    for key, answers in mended:
        found = _bounded(answers)
        times = Counter(min(r.distance, _FAR) for _, r in found if r.distance is not None)
        ties = [r.ties for _, r in found if r.ties is not None]
        if times:
            counts = [times[distance] for distance in range(1, _FAR + 1)]
            yield (*key.cells, *counts, median(ties) if ties else None)


@make_table("kinds", (*SUITE, MODEL, "outcome", "kinds", "answers", "share"), max_shown_rows=20)
def _kinds(mended: _Mended) -> Iterator[Row]:
    """Which kinds of edits suffice.

    Answers that one edit mends, by what they came to: the set of the kinds of all single edits that make them
    right, in percent of those that came to the same.
    """
    for key, answers in mended:
        near = [(record, repair) for record, repair in answers if repair.kinds]
        for error in sorted({outcome_of(record).value for record, _ in near}):
            of_error = [(r, repair) for r, repair in near if outcome_of(r).value == error]
            sets = [" or ".join(repair.kinds) for _, repair in of_error]
            for kinds, number in sorted(Counter(sets).items(), key=lambda each: (-each[1], each[0])):
                yield (*key.cells, error, kinds, number, _share(of_error, [s == kinds for s in sets]))


@make_table("causes", (*SUITE, MODEL, "answers", "step", "interval", "several", "earlier"))
def _causes(mended: _Mended) -> Iterator[Row]:
    """Where the cause lies.

    Answers that one edit mends, by what all such edits have in common: a step, an inserted action (interval),
    or nothing. earlier: where it is a step, those whose step is before the one that failed, in percent.
    """
    for key, answers in mended:
        near = [(record, repair) for record, repair in answers if repair.blame is not None]
        blamed = [(record, repair) for record, repair in near if repair.blame == "step"]
        shown = [(record.verdict.error, repair.blamed) for record, repair in blamed]
        early = [e is not None and None not in (e.step, b) and (b or 0) < (e.step or 0) for e, b in shown]
        times = Counter(repair.blame for _, repair in near)
        if near:
            counts = [times[blame] for blame in ("step", "interval", "several")]
            yield (*key.cells, len(near), *counts, _share(blamed, early))


REPAIR = Study(
    "repair",
    "The fewest edits that make failed answers right, of records scored with --look-back.",
    analyze=_analyze,
)
