"""Errors: what goes wrong by the paper's taxonomy, and which precondition is overlooked."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote, urlencode

from pydantic import Field

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.verdict import share_of_one
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.results.certainty import Case
from eai.results.lines import (
    MODEL,
    SUITE,
    AnswerLine,
    ClauseLine,
    group_by_model,
    group_by_run,
    group_by_suite,
    make_case,
    shares_by_kind,
)
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    OUTCOME_COLORS,
    clip_label,
    denominator_of,
    draw_band,
    draw_matrix,
    draw_names,
    make_figure,
    rows_of,
    value_of,
)
from eai.results.table import Cell, Estimate, Label, Row, Table, make_table
from eai.studies.errors.overview import draw_flows, flow_table
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.figure import Figure


RUNTIME = (
    AnswerOutcome.AFFORDANCE.value,
    AnswerOutcome.MISSING_STEP.value,
    AnswerOutcome.WRONG_ORDER.value,
    AnswerOutcome.UNCATEGORISED.value,
)
"""The errors in which a step cannot be carried out."""

_KINDS = ("state", "relation", "action")
_VERDICTS = ("matched", "additional", "missing")


class _Leaf(NamedTuple):
    """A leaf of the taxonomy: the stage at which an answer fails, the kind of error, and which one."""

    stage: str
    kind: str = ""
    detail: str = ""


def leaf_of(answer: AnswerLine) -> _Leaf:
    """The leaf of an answer; every answer is at one."""
    match AnswerOutcome(answer.outcome):
        case AnswerOutcome.PARSING | AnswerOutcome.ARGUMENT_NUMBER:
            return _Leaf("grammar", answer.outcome)
        case AnswerOutcome.HALLUCINATION:
            unknown = (answer.error_check or "").removeprefix("unknown_")
            return _Leaf("grammar", answer.outcome, unknown)
        case AnswerOutcome.GOAL_MISSED if answer.executable:
            return _Leaf("goal", answer.outcome, "+".join(_missed(answer)))
        case _ if answer.outcome in RUNTIME:
            return _Leaf("runtime", answer.outcome)
        case _:
            return _Leaf(answer.outcome)


def _missed(answer: AnswerLine) -> Iterator[str]:
    for kind in _KINDS:
        met, total = getattr(answer, f"{kind}_met"), getattr(answer, f"{kind}_total")
        if met is not None and met < total:
            yield kind


def error_tables(
    answers: Sequence[AnswerLine], clauses: Sequence[ClauseLine], *, examples: int, explorer: str | None
) -> list[Table]:
    """The tables of the analysis.

    Args:
        answers: the answers.
        clauses: those of operators.
        examples: how many answers to name of each leaf and suite.
        explorer: the address of an explorer of the same records, to which examples lead.
    """
    counted = [answer for answer in answers if answer.outcome != AnswerOutcome.EXCLUDED.value]
    return [
        _leaves(counted),
        _why(counted),
        _additional(counted),
        _clauses(clauses),
        _predicates(clauses),
        _examples(counted, examples, explorer),
        _errors(counted),
        flow_table(counted),
    ]


@make_table("leaves", (*SUITE, MODEL, *_Leaf._fields, "answers"))
def _leaves(answers: Sequence[AnswerLine]) -> Iterator[Row]:
    """Outcomes of answers.

    Answers at each leaf of the taxonomy, in percent of all that count; an answer is at one leaf, that of the
    error that ended it. Of a missed goal the detail says which kinds of goals are not reached.
    """
    for suite, given in group_by_suite(answers).items():
        leaves = sorted({leaf_of(answer) for answer in given}, key=_order)
        for model, lines in group_by_model(given).items():
            shares = shares_by_kind(lines, [leaf_of(line) for line in lines], leaves)
            yield from [(*suite, model, *leaf, share) for leaf, share in shares]


_STAGES = ("success", "partly_right", "goal", "goal_missed", "grammar", "runtime")


def _order(leaf: _Leaf) -> tuple[int, _Leaf]:
    return (_STAGES.index(leaf.stage) if leaf.stage in _STAGES else len(_STAGES), leaf)


@make_table("why", (*SUITE, MODEL, "check", "share"), max_shown_rows=15)
def _why(answers: Sequence[AnswerLine]) -> Iterator[Row]:
    """Which precondition is overlooked.

    Runtime errors (affordance, missing step, wrong order) by the check that failed, in percent of all runtime
    errors of the suite.
    """
    for key, lines in group_by_run([a for a in answers if a.outcome in RUNTIME]):
        checks = [line.error_check or "" for line in lines]
        times = Counter(checks)
        shares = shares_by_kind(lines, checks, sorted(times, key=lambda each: (-times[each], each)))
        yield from [(*key, check, share) for check, share in shares]


@make_table("additional", (*SUITE, MODEL, "answers", "steps"))
def _additional(answers: Sequence[AnswerLine]) -> Iterator[Row]:
    """Additional steps.

    Answers with at least one step that was not needed, in percent, and how many such steps there are. They
    end no plan, so that these answers are at other leaves.
    """
    for key, lines in group_by_run([a for a in answers if a.additional_steps is not None]):
        cases = [make_case(line, share_of_one(bool(line.additional_steps))) for line in lines]
        yield (*key, Estimate.from_cases(cases), sum(a.additional_steps or 0 for a in lines))


@make_table("clauses", (*SUITE, MODEL, "side", "category", *_VERDICTS, "written"))
def _clauses(clauses: Sequence[ClauseLine]) -> Iterator[Row]:
    """Over- and understatement of operators.

    Clauses of operators by side and category: those that are written and right (matched), written and wrong
    (additional), and not written (missing). written: how many are written for each hundred of the data set's
    own; above 100 the model says too much, below too little.
    """
    for key, lines in group_by_run(clauses):
        parts = group_pairs(
            ((line.side, category), line) for line in lines for category in line.categories.split()
        )
        for part, found in sorted(parts.items()):
            counts = [sum(line.verdict == verdict for line in found) for verdict in _VERDICTS]
            yield (*key, *part, *counts, _written_to_gold(found))


def _written_to_gold(lines: Iterable[ClauseLine]) -> Estimate:
    """(matched + additional) / (matched + missing), in percent."""
    found = group_pairs(((line.task, line.name), line.verdict) for line in lines)
    cases = []
    for (task, name), verdicts in found.items():
        written, gold = (len(verdicts) - verdicts.count(left_out) for left_out in ("missing", "additional"))
        cases.append(Case(task, name, Share(written, gold)))
    return Estimate.from_cases(cases)


@make_table("predicates", (*SUITE, MODEL, "side", "verdict", "predicate", "clauses"), max_shown_rows=12)
def _predicates(clauses: Sequence[ClauseLine]) -> Iterator[Row]:
    """Predicates of operators that are missing, or too much.

    Clauses that lack or are wrong, by the predicates in them.
    """
    for key, lines in group_by_run([c for c in clauses if c.verdict != "matched"]):
        counts = Counter(
            (line.side, line.verdict, name) for line in lines for name in line.predicates.split()
        )
        found = sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
        yield from [(*key, *place, count) for place, count in found]


@make_table("examples", (*SUITE, *_Leaf._fields, "answered_by", "task", "check", "objects"))
def _examples(answers: Sequence[AnswerLine], number: int, explorer: str | None) -> Iterator[Row]:
    """Examples.

    The first answers at each leaf, in the order of the records; `eai explain` tells each step by step.
    """
    for suite, given in group_by_suite(answers).items():
        found = group_pairs((leaf_of(answer), answer) for answer in given)
        for leaf in sorted(found, key=_order):
            yield from [
                (*suite, *leaf, a.agent, _place(a, explorer), a.error_check, a.error_objects)
                for a in found[leaf][:number]
            ]


def _place(answer: AnswerLine, explorer: str | None) -> Cell:
    """A task's id, which leads to the answer in an explorer, whose addresses ``explorer/state.js`` reads."""
    if explorer is None:
        return answer.task
    run = "/".join((answer.domain, answer.ability, answer.protocol, answer.model))
    return Label(answer.task, f"{explorer}#{urlencode({'run': run, 'task': answer.task})}")


@make_table(
    "errors",
    (*SUITE, MODEL, "task", "name", *_Leaf._fields, "check", "objects", "step", "annotated_steps"),
    max_shown_rows=0,
)
def _errors(answers: Sequence[AnswerLine]) -> Iterator[Row]:
    """Every error.

    A line an answer that an error ended: its leaf, the check, the objects, the step (from 0), and how many
    steps the data set's own plan has.
    """
    for answer in answers:
        if answer.error_kind is not None:
            key = (answer.protocol, answer.domain, answer.ability, answer.agent, answer.task, answer.name)
            of_error = (answer.error_check, answer.error_objects, answer.error_step)
            yield (*key, *leaf_of(answer), *of_error, answer.annotated_steps)


class _Choices(Options):
    """How errors are sorted.

    Attributes:
        examples: How many answers to name of each kind.
        explorer: An explorer.html by eai report, to which examples link.
    """

    examples: int = Field(default=3, ge=0)
    explorer: Path | None = None


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    explorer = _address(chosen.explorer, records.folder)
    tables = records.tables(features=False)
    found = error_tables(tables.answers, tables.clauses, examples=chosen.examples, explorer=explorer)
    yield Analysis(found, _figures(found))


def _address(explorer: Path | None, folder: Path) -> str | None:
    """The address of an explorer as seen from a folder.

    Raises:
        InputError: there is none.
    """
    if explorer is None:
        return None
    if not explorer.is_file():
        raise InputError(f"explorer={explorer}: no such file; eai report writes explorer.html")
    return quote(Path(os.path.relpath(explorer, folder)).as_posix())


def _figures(found: Sequence[Table]) -> Figures:
    leaves, why = found[:2]
    yield from draw_flows(found[-1])
    for suite, rows in rows_of(leaves).items():
        yield of_suite(suite, "flow", draw(rows))
        levels = ("stage", "kind", "detail")
        yield of_suite(suite, "leaves", draw_matrix(rows, levels, "answers", "percent of answers"))
    for suite, rows in rows_of(why).items():
        yield of_suite(suite, "why", draw_names(rows, "check", "share", "share of runtime errors"))


_GAP = 4.0
"""Percent between stages, and between what leaves of different stages are labelled with."""

_SMALLEST = 0.5
"""Percent below which a leaf is a band without a name."""

_LINE = 5.6
"""Percent that a line of text takes."""

_COLORS: Mapping[str, str] = {
    "success": OUTCOME_COLORS[AnswerOutcome.SUCCESS],
    "grammar": OUTCOME_COLORS[AnswerOutcome.PARSING],
    "runtime": OUTCOME_COLORS[AnswerOutcome.MISSING_STEP],
    "goal": OUTCOME_COLORS[AnswerOutcome.GOAL_MISSED],
}


def draw(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """Draw the outcomes of all models' answers, or of the only one's; None if there are none.

    Args:
        rows: those of a suite in the table of leaves.
    """
    first = rows[0]["model"] if rows else None
    cells = {_leaf(row): row["answers"] for row in rows if row["model"] == first}
    shares = {leaf: value_of(cell) for leaf, cell in cells.items()}
    shares = {leaf: share for leaf, share in shares.items() if share > 0}
    if not shares:
        return None
    stages = list(dict.fromkeys(stage for stage, _ in shares))
    named = [leaf for leaf, share in shares.items() if share >= _SMALLEST]
    figure = make_figure(COLUMN, 1.2 + 0.13 * len(named))
    panel = figure.subplots()
    panel.set_axis_off()
    answers = max(map(denominator_of, cells.values()))
    panel.set_title(f"{clip_label(str(first))}, percent of {answers:,} answers", fontsize=7.5)
    top, stage_top, text_top = 100.0, 100.0 + _GAP * (len(stages) - 1) / 2, 104.0
    for stage in stages:
        leaves = {leaf: share for leaf, share in shares.items() if leaf[0] == stage}
        whole, color = sum(leaves.values()), _COLORS.get(stage, MUTED)
        draw_band(panel, 0, (top - whole, stage_top - whole, whole), color)
        at = stage_top
        for leaf, share in leaves.items():
            middle = at - share / 2
            panel.fill_between([1, 1.12], at - share, at, facecolor=color, edgecolor="white", linewidth=0.5)
            if share >= _SMALLEST:
                name = leaf[1] or stage.replace("_", " ")
                text_top = min(middle, text_top - _LINE)
                panel.plot([1.12, 1.2], [middle, text_top], color=MUTED, linewidth=0.6)
                panel.text(1.22, text_top, f"{name} {share:.1f}", fontsize=6.5, va="center", color=INK)
            at -= share
        top -= whole
        stage_top -= whole + _GAP
    panel.set_xlim(-0.02, 2.2)
    panel.set_ylim(min(stage_top, text_top) - _GAP, 104 + _GAP)
    return figure


def _leaf(row: Mapping[str, Cell]) -> tuple[str, str]:
    parts = [str(row[level]).replace("_", " ") for level in ("kind", "detail") if row[level]]
    return str(row["stage"]), ": ".join(parts)


ERRORS = Study(
    "errors",
    "Errors by the paper's taxonomy, and which check failed how often.",
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
