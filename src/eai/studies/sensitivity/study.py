"""Sensitivity analysis (paper, "Sensitivity analysis" of transition modeling): which operator breaks plans?

In each task one operator at a time is the answer's, the others are the gold ones; a planner says whether
the problem can still be solved. Counted are the successes by operator, and by operator and category of the
task, out of all tasks that ask for it: an operator that the answer does not have is no success.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import cache, partial
from itertools import product
from typing import Annotated, get_args

from pydantic import BeforeValidator

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.rules import ReplacedPart
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import share_of_one
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results.certainty import Case
from eai.results.lines import MODEL, SUITE, TidyLine, group_by_model, group_by_suite, make_case
from eai.results.plots import draw_matrix, numerator_of, rows_of
from eai.results.record import Record
from eai.results.table import Estimate, Row, Table, make_table
from eai.results.tidy import first_columns
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite, several
from eai.tasks.options import Options
from eai.tasks.source import Source
from eai.tasks.task import Category

OVERALL = "overall"
"""The category of all tasks."""

NOT_WRITTEN = "not_written"
"""The outcome of an operator that is asked for and not in the answer."""

_SOLVED = PlannerOutcome.SOLVED.value
_OUTCOMES = (*(o.value for o in PlannerOutcome if o is not PlannerOutcome.NOT_RUN), NOT_WRITTEN)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial(TidyLine):
    """One operator of one answer, tried among gold ones.

    Attributes:
        replaced: what of the gold operator gave way (`ReplacedPart`).
        operator: its name.
        outcome: how the planner ended (`PlannerOutcome`), or `NOT_WRITTEN`.
        categories: those of the task, with blanks between.
        errors: what is wrong with it, ``side:verdict:predicate``, each once, with blanks between.
    """

    replaced: str
    operator: str
    outcome: str
    categories: str
    errors: str


def tried(
    records: Sequence[Record], source: Source, ways: Sequence[ReplacedPart], done: Callable[[int], None]
) -> Iterator[Trial]:
    """Try all operators of records; all models share a suite, so that equal ones are planned with once."""
    opened = cache(partial(open_suite, ability=Ability.TRANSITION_MODELING, source=source))
    for number, record in enumerate(records, 1):
        scorer = opened(record.domain, protocol=record.protocol).scorer(record.task_id)
        if isinstance(scorer, TransitionModeling):
            for way in ways:
                yield from try_operators(scorer, record, way)
        done(number)


def try_operators(
    scorer: TransitionModeling, record: Record, replaced: ReplacedPart = "operator"
) -> Iterator[Trial]:
    """Try each operator that a task asks for, as the record's answer has it.

    Nothing comes of an answer that the rules leave out; one that is missing has no operator.
    """
    errors = _errors(record, replaced)
    results = scorer.plan_one_at_a_time(record.response, replaced)
    if record.unanswered is not None:
        results = dict.fromkeys(scorer.task.operators)
    for operator, result in results.items():
        yield Trial(
            **first_columns(record),
            replaced=replaced,
            operator=operator,
            outcome=NOT_WRITTEN if result is None else result.outcome.value,
            categories=" ".join(category.value for category in scorer.task.categories),
            errors=" ".join(errors.get(operator, ())),
        )


def _errors(record: Record, replaced: ReplacedPart) -> dict[str, tuple[str, ...]]:
    """The errors in the tried part of each operator."""
    if not isinstance(record.verdict, OperatorVerdict):
        return {}
    sides = [side for side in ("precondition", "effect") if replaced in (side, "operator")]
    return {
        report.name: tuple(
            dict.fromkeys(
                f"{side}:{found}:{predicate}"
                for side in sides
                for found in ("missing", "additional")
                for clause in getattr(getattr(report, side), found)
                for predicate in record.verdict.clauses[clause].predicates
            )
        )
        for report in record.verdict.operators
    }


def sensitivity_tables(trials: Sequence[Trial]) -> list[Table]:
    """The tables of the analysis."""
    return [_sensitivity(trials), _outcomes(trials), _errors_table(trials), _trials(trials)]


def cells_of(trials: Iterable[Trial]) -> dict[tuple[str, str], list[Case]]:
    """The cases that trials add to success, by operator and category, `OVERALL` first."""
    return group_pairs(
        ((trial.operator, category), make_case(trial, share_of_one(trial.outcome == _SOLVED)))
        for trial in trials
        for category in (OVERALL, *trial.categories.split())
    )


def _by_model(trials: Sequence[Trial]) -> Iterator[tuple[tuple[str, ...], list[Trial], list[str]]]:
    """The trials of each suite, model and way to replace, what they are of, and the suite's operators.

    These are in order of success, the one that breaks most plans first.
    """
    for suite, lines in group_by_suite(trials).items():
        tried = Counter(trial.operator for trial in lines)
        solved = Counter(trial.operator for trial in lines if trial.outcome == _SOLVED)
        order = sorted(tried, key=lambda name: (solved[name] / tried[name], name))
        for model, of_model in group_by_model(lines).items():
            for replaced in get_args(ReplacedPart):
                found = [trial for trial in of_model if trial.replaced == replaced]
                if found:
                    yield (*suite, model, replaced), found, order


_KEY = (*SUITE, MODEL, "replaced")


@make_table("sensitivity", (*_KEY, "operator", "category", "solved"))
def _sensitivity(trials: Sequence[Trial]) -> Iterator[Row]:
    """Problems solved with one operator of the model.

    Tasks that a planner solves with this operator as the answer has it and all others as the data set has
    them (strict: those that the task asks for; eai-1.0.5: all of the benchmark's), in percent of those that
    ask for it; one that is not written solves nothing. replaced: the whole operator, or only its precondition
    or its effect, with the parameters of the data set. A task counts in each of its categories. Operators
    that break most plans come first; intervals have names as units.
    """
    categories = (OVERALL, *(category.value for category in Category))
    for key, found, order in _by_model(trials):
        cells = cells_of(found)
        for place in product(order, categories):
            if place in cells:
                yield (*key, *place, Estimate.from_cases(cells[place]))


@make_table("outcomes", (*_KEY, "operator", *_OUTCOMES))
def _outcomes(trials: Sequence[Trial]) -> Iterator[Row]:
    """How trials ended.

    Trials of each operator by how the planner ended: with a plan, without one, because the operator is no
    acceptable PDDL, at a limit; or because the answer does not have the operator.
    """
    for key, found, order in _by_model(trials):
        counts = Counter((trial.operator, trial.outcome) for trial in found)
        for name in order:
            row = [counts[name, outcome] for outcome in _OUTCOMES]
            if any(row):
                yield (*key, name, *row)


@make_table(
    "errors",
    (*_KEY, "operator", "side", "verdict", "predicate", "unsolved_with", "unsolved_without"),
    max_shown_rows=20,
)
def _errors_table(trials: Sequence[Trial]) -> Iterator[Row]:
    """Which error breaks plans.

    Operators that are written, by a predicate that is missing or too much on one of their sides: the tasks
    that are not solved with such an operator, and those that are not solved with the same one without this
    error, in percent. Errors come together, so that one may stand for another; those that stand beside most
    failures come first.
    """
    for key, found, order in _by_model([trial for trial in trials if trial.outcome != NOT_WRITTEN]):
        of_operators = group_pairs((trial.operator, trial) for trial in found)
        of_key = [(name, *row) for name in order for row in _of_errors(of_operators.get(name, ()))]
        yield from [(*key, *row) for row in sorted(of_key, key=lambda row: -numerator_of(row[-2]))]


def _of_errors(trials: Sequence[Trial]) -> Iterator[Row]:
    """Each error of an operator with how often trials fail with and without it, the most frequent first."""
    errors = [frozenset(trial.errors.split()) for trial in trials]
    cases = [make_case(trial, share_of_one(trial.outcome != _SOLVED)) for trial in trials]
    counts = Counter(error for each in errors for error in each)
    for error in sorted(counts, key=lambda each: (-counts[each], each)):
        split = list(zip(cases, errors, strict=True))
        yield (
            *error.split(":", 2),
            Estimate.from_cases([case for case, each in split if error in each]),
            Estimate.from_cases([case for case, each in split if error not in each]),
        )


@make_table("trials", tuple([column.name for column in fields(Trial)]), max_shown_rows=0)
def _trials(trials: Sequence[Trial]) -> Iterable[Row]:
    """Every trial.

    A line an operator of an answer: how the planner ended, the task's categories, and what is wrong with the
    operator, as side, verdict and predicate.
    """
    return map(astuple, trials)


class _Choices(Options):
    """How operators are tried.

    Attributes:
        replace: What of a gold operator is the model's: operator, precondition or effect; several with
            commas.
        planner: What finds plans: auto, fast_downward or built_in.
    """

    replace: Annotated[tuple[ReplacedPart, ...], BeforeValidator(several)] = ("operator",)
    planner: PlannerChoice = PlannerChoice.AUTO


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    """Operators are tried one by one, which takes a planner minutes a model.

    Raises:
        InputError: there are no operators, or no planner is to try them.
    """
    if chosen.planner is PlannerChoice.NONE:
        raise InputError("planner=none: operators are tried by a planner")
    runs = [run for run in records.runs() if run.key.ability is Ability.TRANSITION_MODELING]
    found = [record for run in runs for record in run.records]
    if not found:
        raise InputError("expected records of transition modeling, found none")
    ways = tuple(dict.fromkeys(chosen.replace))
    source = replace(records.source, planner=chosen.planner)
    with records.progress("trying operators", len(found)) as done:
        tables = sensitivity_tables(list(tried(found, source, ways, done)))
    yield Analysis(tables, _figures(tables, ways))


def _figures(tables: Sequence[Table], ways: Sequence[ReplacedPart]) -> Figures:
    for suite, rows in rows_of(tables[0]).items():
        for way in ways:
            of_way = [row for row in rows if row["replaced"] == way]
            label = f"percent solved with the model's {way}"
            shown = [row for row in of_way if row["category"] == OVERALL]
            models = draw_matrix(shown, ("operator",), "solved", label, zeros=True)
            yield of_suite(suite, way, models)
            shown = [row for row in of_way if row["model"] == of_way[0]["model"]]
            categories = draw_matrix(shown, ("operator",), "solved", label, across="category", zeros=True)
            yield of_suite(suite, f"{way}-categories", categories)


SENSITIVITY = Study(
    "sensitivity",
    "Each operator of the answers alone among gold operators: which one breaks plans (transition modeling).",
    choices=_Choices,
    analyze=_analyze,
)
