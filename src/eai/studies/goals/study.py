"""Goals: which ones models find, miss and make up (paper, section "Goal interpretation": reporting bias)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import get_args

from eai.abilities.verdict import share_of_one
from eai.base.grouping import group_pairs
from eai.results.certainty import Case
from eai.results.lines import (
    MODEL,
    SUITE,
    AtomLine,
    WrongGoalReason,
    group_by_run,
    group_by_suite,
    make_case,
    shares_by_kind,
)
from eai.results.plots import draw_matrix, draw_names, rows_of
from eai.results.table import Estimate, Row, Table, make_table
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite
from eai.tasks.options import Options

MATCHED, WRONG, MISSING = "matched", "wrong", "missing"
_VERDICTS = (MATCHED, WRONG, MISSING)


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    found = goal_tables(records.tables().atoms)
    yield Analysis(found, _figures(found))


def goal_tables(atoms: Sequence[AtomLine]) -> list[Table]:
    """The tables of the analysis, from the goals that answers state or should state."""
    return [_by_predicate(atoms), _reasons(atoms), _wrong(atoms), _shared(atoms)]


@make_table(
    "by_predicate", (*SUITE, MODEL, "predicate", *_VERDICTS, "precision", "recall"), max_shown_rows=30
)
def _by_predicate(atoms: Sequence[AtomLine]) -> Iterator[Row]:
    """Goals by predicate.

    Conditions of the tasks that are stated (matched) or not (missing), and stated goals that are none
    (wrong), by predicate or action; a denied goal is one of its predicate. Precision is matched of stated,
    recall is matched of asked, in percent; what names something that does not exist is in neither where the
    protocol leaves it out.
    """
    for key, lines in group_by_run(atoms):
        names = group_pairs((line.predicate, line) for line in lines)
        asked = {name: sum(line.verdict != WRONG for line in found) for name, found in names.items()}
        for name, found in sorted(names.items(), key=lambda pair: (-asked[pair[0]], pair[0])):
            counts = Counter(line.verdict for line in found)
            yield (*key, name, *(counts[v] for v in _VERDICTS), *_scores(found))


def _scores(lines: Sequence[AtomLine]) -> tuple[Estimate, Estimate]:
    """Precision and recall."""
    return (
        Estimate.from_cases([_case(line) for line in lines if line.verdict != MISSING]),
        Estimate.from_cases([_case(line) for line in lines if line.verdict != WRONG]),
    )


def _case(line: AtomLine) -> Case:
    return make_case(line, share_of_one(line.verdict == MATCHED))


@make_table("reasons", (*SUITE, MODEL, "reason", "share"))
def _reasons(atoms: Sequence[AtomLine]) -> Iterator[Row]:
    """Where wrong goals come from.

    Wrong goals by the first of these reasons that fits, in percent of all wrong goals. unknown: the predicate
    or action is none of the benchmark's; procedural: an action that is a goal of no task; initial: it holds
    at the start; final: it holds at the end of the data set's own plan, and nobody asked for it;
    intermediate: it holds at some time on the way there, neither at the start nor at the end.
    """
    for key, lines in group_by_run([a for a in atoms if a.reason is not None]):
        reasons = [str(line.reason) for line in lines]
        shares = shares_by_kind(lines, reasons, get_args(WrongGoalReason))
        yield from [(*key, reason, share) for reason, share in shares]


@make_table(
    "wrong", (*SUITE, MODEL, "predicate", "reason", "goals"), title="What is made up most", max_shown_rows=15
)
def _wrong(atoms: Sequence[AtomLine]) -> Iterator[Row]:
    """Wrong goals, by how often they are made up.

    Wrong goals by predicate or action and reason.
    """
    for key, lines in group_by_run([a for a in atoms if a.verdict == WRONG]):
        counts = Counter((line.predicate, line.reason) for line in lines)
        for (predicate, reason), count in sorted(counts.items(), key=lambda pair: (-pair[1], str(pair[0]))):
            yield (*key, predicate, reason, count)


@make_table(
    "shared",
    (*SUITE, "task", "goal", *_VERDICTS, "models"),
    title="What many models do alike",
    max_shown_rows=15,
)
def _shared(atoms: Sequence[AtomLine]) -> Iterator[Row]:
    """Goals, by how many models state or miss each.

    Every goal that is asked or stated: how many models state it, rightly or wrongly, how many should and do
    not, of all with answers in the suite; those that most models miss or make up come first.
    """
    for suite, lines in group_by_suite(atoms).items():
        models = len({line.agent for line in lines})
        found = sorted(_of_goals(lines), key=lambda row: (-row[3] - row[4], row[3], row[0], row[1]))
        yield from [(*suite, *row, models) for row in found]


def _of_goals(lines: Sequence[AtomLine]) -> Iterator[tuple[str, str, int, int, int]]:
    """Task, goal, and how many models are right, wrong about it, and miss it."""
    found = group_pairs(((line.task, line.atom), (line.verdict, line.agent)) for line in lines)
    for (task, goal), said in found.items():
        right, wrong, missing = (len({a for verdict, a in said if verdict == each}) for each in _VERDICTS)
        yield task, goal, right, wrong, missing


def _figures(found: Sequence[Table]) -> Figures:
    by_predicate, reasons = found[:2]
    for suite, rows in rows_of(by_predicate).items():
        for score in ("precision", "recall"):
            yield of_suite(suite, score, draw_names(rows, "predicate", score, score))
    for suite, rows in rows_of(reasons).items():
        yield of_suite(suite, "reasons", draw_matrix(rows, ("reason",), "share", "percent of wrong goals"))


GOALS = Study(
    "goals",
    "Goal interpretation by predicate: found, missed and made up, and where wrong goals come from.",
    analyze=_analyze,
    together=True,
)
