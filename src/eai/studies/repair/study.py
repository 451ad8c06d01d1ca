"""Study the edits (steps to insert, delete or replace) that make failed answers right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from statistics import median

from eai.abilities.repair import SmallestPlanRepair
from eai.base.errors import InputError
from eai.results.lines import MODEL, SUITE
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import estimate_share, find_answer_outcome
from eai.results.table import Estimate, Row, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Study
from eai.tasks.options import Options

_MAX_DISTANCE = 5
"""Distance that begins the last column of the table; larger distances are counted in the same column.

The distance of a failed answer is the number of edits that make it right.
"""


def _analyze_repairs(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    repairs = [
        (run.key, pairs) for run in records.read_runs() if (pairs := list(_list_recorded_repairs(run)))
    ]
    repairs.sort(key=lambda pair: pair[0].sort_key)
    tables = [
        _make_edit_distances_table(repairs),
        _make_edits_table(repairs),
        _make_edit_kinds_table(repairs),
        _make_failure_causes_table(repairs),
    ]
    if not tables[0].rows:
        raise InputError(
            "expected records with repairs (edits that make a failed plan right), found none; "
            "score the answers again by eai score --look-back 20000"
        )
    yield Analysis(tables, screen_tables=tables[:1])


def _list_recorded_repairs(run: Run) -> Iterator[tuple[Record, SmallestPlanRepair]]:
    """Yield each failed answer of a run, with its repair: the edits that would make the plan right.

    Answers without a repair in their record are left out.
    """
    for record in run.records:
        repair = record.verdict.repair
        if repair is not None and repair.at_most != 0:
            yield record, repair


_RepairsByRun = Sequence[tuple[RunKey, list[tuple[Record, SmallestPlanRepair]]]]


def _estimate_share_of_answers(
    answers: Sequence[tuple[Record, SmallestPlanRepair]], is_counted: Sequence[bool]
) -> Estimate:
    return estimate_share([record for record, _ in answers], is_counted)


@collect_rows_in_table("distances", (*SUITE, MODEL, "failed", "unknown", "exact", "within_2", "one_edit"))
def _make_edit_distances_table(repairs: _RepairsByRun) -> Iterator[Row]:
    """How far failed answers are from right ones.

    The distance of a failed answer is the smallest number of edits (steps inserted, deleted or replaced) that
    make it right. unknown: number of answers without known bounds of the distance, mostly unreadable answers.
    In percent of the other failed answers: exact (the distance is known), within_2 (its bounds differ by at
    most two), and one_edit (a single edit suffices).
    """
    for key, answers in repairs:
        bounded = _select_answers_with_known_distance_bounds(answers)
        if not bounded:
            continue
        near = [r.at_most is not None and r.at_most - r.at_least <= 2 for _, r in bounded]
        exact = [r.distance is not None for _, r in bounded]
        single = [r.distance == 1 for _, r in bounded]
        shares = [_estimate_share_of_answers(bounded, counted) for counted in (exact, near, single)]
        yield (*key.protocol_domain_ability_and_name, len(bounded), len(answers) - len(bounded), *shares)


def _select_answers_with_known_distance_bounds(
    answers: Sequence[tuple[Record, SmallestPlanRepair]],
) -> list[tuple[Record, SmallestPlanRepair]]:
    """Return the answers for which bounds of the distance (smallest number of edits to success) are known."""
    return [(record, repair) for record, repair in answers if repair.why_null is None]


@collect_rows_in_table("edits", (*SUITE, MODEL, "1", "2", "3", "4", "5+", "ties"))
def _make_edits_table(repairs: _RepairsByRun) -> Iterator[Row]:
    """How many edits it takes.

    Columns 1 to 5+: numbers of failed answers by their distance, the smallest number of edits that make an
    answer right. Column ties: for answers of distance 1, the median number of different edits that make the
    answer right.
    """
    for key, answers in repairs:
        bounded = _select_answers_with_known_distance_bounds(answers)
        times = Counter(min(r.distance, _MAX_DISTANCE) for _, r in bounded if r.distance is not None)
        ties = [r.ties for _, r in bounded if r.ties is not None]
        if times:
            counts = [times[distance] for distance in range(1, _MAX_DISTANCE + 1)]
            yield (*key.protocol_domain_ability_and_name, *counts, median(ties) if ties else None)


@collect_rows_in_table("kinds", (*SUITE, MODEL, "outcome", "kinds", "answers", "share"), max_shown_rows=20)
def _make_edit_kinds_table(repairs: _RepairsByRun) -> Iterator[Row]:
    """Kinds of edits that make an answer right.

    The table counts answers that a single edit makes right. outcome: outcome of the answers. kinds: the kinds
    of all such edits (insert, delete and so on). share: answers with these kinds, in percent of the counted
    answers with this outcome.
    """
    for key, answers in repairs:
        near = [(record, repair) for record, repair in answers if repair.kinds]
        for error in sorted({find_answer_outcome(record).value for record, _ in near}):
            of_error = [(r, repair) for r, repair in near if find_answer_outcome(r).value == error]
            sets = [" or ".join(repair.kinds) for _, repair in of_error]
            for kinds, number in sorted(Counter(sets).items(), key=lambda pair: (-pair[1], pair[0])):
                yield (
                    *key.protocol_domain_ability_and_name,
                    error,
                    kinds,
                    number,
                    _estimate_share_of_answers(of_error, [s == kinds for s in sets]),
                )


@collect_rows_in_table("causes", (*SUITE, MODEL, "answers", "step", "interval", "several", "earlier"))
def _make_failure_causes_table(repairs: _RepairsByRun) -> Iterator[Row]:
    """Step that causes a failure.

    answers: failed answers whose plan a single edit makes right. step: answers for which all these edits
    concern one step: they delete it, replace it, or insert an action before it. interval: answers for which
    all these edits insert the same action, at different positions. several: all other answers. earlier: of
    the answers in column step, the percentage whose edited step comes before the failed step.
    """
    for key, answers in repairs:
        near = [(record, repair) for record, repair in answers if repair.blame is not None]
        blamed = [(record, repair) for record, repair in near if repair.blame == "step"]
        shown = [(record.verdict.error, repair.blamed) for record, repair in blamed]
        early = [e is not None and None not in (e.step, b) and (b or 0) < (e.step or 0) for e, b in shown]
        times = Counter(repair.blame for _, repair in near)
        if near:
            counts = [times[blame] for blame in ("step", "interval", "several")]
            yield (
                *key.protocol_domain_ability_and_name,
                len(near),
                *counts,
                _estimate_share_of_answers(blamed, early),
            )


REPAIR = Study(
    "repair",
    "The fewest edits that make failed answers right, of records scored with --look-back.",
    analyze=_analyze_repairs,
)
