"""Measure formulas of 20 operators on traces of 1,000 states, and the reading of answers.

    python -m bench logic

The limit is 10 ms for one evaluation, including the truth of atoms. The slowest form mixes ``then`` with
negated ``then`` in front of ``then``, which must be evaluated on every segment of the trace. For comparison,
the naive evaluator of the tests runs on a trace of 30 states in the same run.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

from bench.record import add_write_option, write_figures
from eai.logic.formula import Formula
from eai.logic.ltl import parse, read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.semantics import holds
from eai.logic.signature import FormulaSignature
from eai.logic.trace import TakenAction, Trace
from eai.logic.traversal import get_subformulas, walk_subformulas
from logic.naive import Facts, Naive

LIMIT_MS = 10.0
NAMES = tuple(f"cup.{i}" for i in range(10))
SHELVES = tuple(f"shelf.{i}" for i in range(3))
OBJECTS = (*((name, "cup") for name in NAMES), *((name, "shelf") for name in SHELVES))
SIGNATURE = FormulaSignature({"open": 1, "clean": 1, "next_to": 2}, {"grab": 1, "pour": 2})
FORMULAS = {
    "state": """
        (open(cup.1) or not clean(cup.2)) and (open(cup.3) or not clean(cup.4))
        and not (open(cup.5) and clean(cup.6)) and (open(cup.7) or clean(cup.8) or not open(cup.9))
        and not (grab(cup.1) or grab(cup.2) or not (clean(cup.0) and not open(cup.8)))
        and not (clean(cup.9) and grab(cup.3))
    """,
    "then": """
        open(cup.1) then not open(cup.2) and clean(cup.3) then grab(cup.1) or grab(cup.2)
        then (open(cup.4) then clean(cup.5) or not open(cup.6)) or (clean(cup.7) then open(cup.8))
        then not (open(cup.9) and clean(cup.9)) then open(cup.0) or open(cup.1) and not clean(cup.1)
        then clean(cup.2) then open(cup.3)
    """,
    "conjunctions of then": """
        ((open(cup.1) then clean(cup.1)) and (open(cup.2) then clean(cup.2))
            and (open(cup.3) then clean(cup.3) then not open(cup.0))
            and (open(cup.4) then clean(cup.4) then open(cup.5)))
        then ((open(cup.6) then clean(cup.6)) and (open(cup.7) then not clean(cup.7)))
        then open(cup.8) and not open(cup.9) then clean(cup.1) or open(cup.1)
        then clean(cup.2)
    """,
    "quantifiers": """
        exists x. (open(x) and exists y: shelf. (next_to(x, y) and not clean(y)))
        then forn 3 x. (open(x) or clean(x) and not next_to(x, shelf.1))
        then forall x. (not open(x) or clean(x) or next_to(x, shelf.2))
        then exists x. (grab(x) and not open(x))
        then (exists x. (exists y. (pour(x, y))) then open(cup.1)) or open(cup.2)
    """,
    "beyond the paper": """
        always (open(cup.1) implies eventually clean(cup.1))
        and (open(cup.2) until clean(cup.3) or next next next open(cup.4))
        and eventually always (not open(cup.5) or next clean(cup.5))
        and always eventually (open(cup.6) and not clean(cup.7) or grab(cup.8))
        and not always (open(cup.9) until clean(cup.0))
    """,
    "negation before then": """
        not (open(cup.1) then clean(cup.1) then open(cup.2))
        then (always (open(cup.3) or clean(cup.3))
            or not (open(cup.4) and clean(cup.4) then open(cup.5) or clean(cup.5)))
        then not (open(cup.6) then not clean(cup.6) then open(cup.7))
        then open(cup.8) and not open(cup.9)
        then clean(cup.1) or open(cup.1)
    """,
    "mixture before then": """
        not (open(cup.1) then clean(cup.1) then open(cup.2)) and (clean(cup.2) then not open(cup.2))
        then (always (open(cup.3) or clean(cup.3))
            and (open(cup.4) and clean(cup.4) then open(cup.5) or clean(cup.5)))
        then not (open(cup.6) then not clean(cup.6) then open(cup.7))
        then open(cup.8) and not open(cup.9)
        then clean(cup.1) or open(cup.1)
    """,
}
"""Formulas with at least 20 operators each, by the part of evaluation that they stress."""


def make_states(count: int) -> list[Facts]:
    """Return states in which facts become true and false with various periods."""

    def true(i: int) -> frozenset[tuple[str, tuple[str, ...]]]:
        unary = {
            (p, (n,))
            for k, n in enumerate(NAMES)
            for j, p in enumerate(("open", "clean"))
            if (i + j) % (k + 2) == 0
        }
        pairs = {("next_to", (NAMES[i % 10], SHELVES[i * 7 % 3]))}
        return frozenset(unary | pairs)

    return [Facts(true(i), OBJECTS) for i in range(count)]


def make_actions(count: int) -> list[TakenAction]:
    return [("grab", (NAMES[i % 10],)) if i % 3 else ("pour", (NAMES[i % 10], "cup.1")) for i in range(count)]


def evaluate(formula: Formula, states: list[Facts], actions: list[TakenAction]) -> bool:
    return holds(formula, Trace(states, actions))


def measure_milliseconds(run: Callable[[], object], repetitions: int) -> float:
    """Return the CPU time of one run in milliseconds: the minimum of three series."""
    series = []
    for _ in range(3):
        start = time.process_time()
        for _ in range(repetitions):
            run()
        series.append((time.process_time() - start) * 1000 / repetitions)
    return min(series)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_write_option(parser)
    arguments = parser.parse_args()
    long_states, long_actions = make_states(1000), make_actions(999)
    short = Naive(tuple(make_states(30)), tuple(make_actions(29)))
    slowest = 0.0
    for name, text in FORMULAS.items():
        formula = read_formula(text, SIGNATURE)[0]
        operators = sum(
            max(1, len(get_subformulas(part)) - 1)
            for part in walk_subformulas(formula)
            if get_subformulas(part)
        )
        spent = measure_milliseconds(partial(evaluate, formula, long_states, long_actions), 5)
        naive = measure_milliseconds(partial(short.on, formula, 0, 29, {}), 1)
        slowest = max(slowest, spent)
        print(f"{name:>24}: {operators} operators {spent:7.2f} ms; naively, on 30 states {naive:7.2f} ms")
    for count in (8, 30):
        text = " then ".join(f"next_to(cup.{i % 10}, cup.{i % 7})" for i in range(count))
        spent = measure_milliseconds(partial(read_formula, text, SIGNATURE, "release"), 100)
        printed = measure_milliseconds(partial(format_ltl, parse(text)), 100)
        print(f"{f'{count} subgoals':>24}: read in {spent:.3f} ms, printed in {printed:.3f} ms")
    if arguments.write:
        write_figures("logic", {"CPU ms for the slowest formula on 1,000 states": round(slowest, 1)})
    if slowest > LIMIT_MS:
        raise SystemExit(f"slowest evaluation: {slowest:.1f} ms, limit {LIMIT_MS} ms")
