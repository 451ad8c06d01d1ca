"""Writes short tests and difficulties from records of many models: `python tools/short_tests.py RECORDS...`.

Prints for each suite how many percent of the pairs of models that had no part in choosing are in the order
of the whole suite, and how many points their scores are from those of the whole suite: for the chosen tasks,
and for as many that are drawn at random. Difficulties are those of
suites whose answers are right or wrong without a planner. What other suites have stays as it is.

Tasks are sorted by their difficulty in the Rasch model, and every so many-th is taken, so that the short test
has easy and difficult ones in the same proportion as the suite. Tasks of most information about the models at
hand are no better a choice: they order these models well, and others no better than tasks drawn at random
(``docs/extensions/adaptive``).
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from statistics import fmean
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.extensions.adaptive import difficulties as adaptive
from eai.extensions.adaptive import short_tests
from eai.extensions.adaptive.rasch import fit_rasch, variance_between
from eai.extensions.adaptive.study import Scores, scores_of
from eai.results.lines import group_by_suite
from eai.results.rate import Rate
from eai.studies.records import Records

SOURCE = Path(__file__).resolve().parents[1] / "src" / "eai"
TESTS = SOURCE / "extensions" / "adaptive" / short_tests.FILE
DIFFICULTIES = SOURCE / "extensions" / "adaptive" / adaptive.FILE

Matrix: TypeAlias = NDArray[np.float64]

TASKS = 40
"""How many tasks a short test has."""

HELD_OUT = 4
"""How many models at a time do not choose, but are ordered."""

_DRAWS = 10


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    answers = Records(tuple(map(Path, sys.argv[1:]))).tables().answers
    tests: dict[str, list[str]] = _read(TESTS)
    difficulties: dict[str, dict[str, Any]] = _read(DIFFICULTIES)
    for suite, of_suite in group_by_suite(answers).items():
        if suite.protocol != DEFAULT_PROTOCOL.value:
            sys.exit(f"expected records under {DEFAULT_PROTOCOL.value}, not {suite.protocol}")
        scores = scores_of(of_suite)
        found = cross_validate(scores)
        name = f"{suite.domain}/{Ability(suite.ability).value}"
        tests[name] = list(choose(scores))
        if declaration_of(Ability(suite.ability)).has_plans:
            difficulties[name] = difficulties_of(scores)
        models = f"{len(scores.models)} models"
        chosen, drawn = (
            f"{each.ordered.percent:.1f} {each.distance:.1f}" for each in (found.chosen, found.drawn)
        )
        print(f"{name:40} {models}  chosen {chosen}  drawn {drawn}", flush=True)
    for file, content in ((TESTS, tests), (DIFFICULTIES, difficulties)):
        text = json.dumps(dict(sorted(content.items())), indent=1)
        file.write_text(text + "\n", encoding="utf-8")


def difficulties_of(scores: Scores) -> dict[str, Any]:
    """Each task's difficulty, from the mean ability of the models, and how these vary between names."""
    fitted = fit_rasch(scores.matrix)
    shifted = fitted.difficulties - fitted.abilities.mean()
    return {
        "variance_between_names": round(variance_between(scores.matrix, fitted, scores.names), 3),
        "difficulties": {
            task: round(float(value), 3) for task, value in zip(scores.tasks, shifted, strict=True)
        },
    }


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def choose(scores: Scores, number: int = TASKS) -> tuple[str, ...]:
    """The tasks of a short test, in the order of the suite; all if it has no more."""
    chosen = set(_chosen(scores.matrix, number))
    return tuple(task for place, task in enumerate(scores.tasks) if place in chosen)


def _chosen(matrix: Matrix, number: int) -> list[int]:
    difficulties = fit_rasch(matrix).difficulties
    order = sorted(range(len(difficulties)), key=lambda place: (round(float(difficulties[place]), 9), place))
    if len(order) <= number:
        return order
    return [order[(2 * step + 1) * len(order) // (2 * number)] for step in range(number)]


@dataclass(frozen=True, slots=True)
class Fidelity:
    """How like the whole suite short tests are.

    Attributes:
        ordered: pairs of models that are in the order of the whole suite, a tie being half of one.
        distance: the root of the mean squared difference between a model's score in the short test and in the
            whole suite, in points of percent.
    """

    ordered: Rate
    distance: float


@dataclass(frozen=True, slots=True)
class Validity:
    """How well short tests do for models that had no part in choosing them.

    Attributes:
        chosen: with the tasks that the other models choose.
        drawn: with as many that are drawn at random.
    """

    chosen: Fidelity
    drawn: Fidelity


def cross_validate(scores: Scores, number: int = TASKS) -> Validity:
    """Choose with some models, look at the others; all ways to hold out `HELD_OUT` of them."""
    matrix, generator = scores.matrix, np.random.default_rng(0)
    whole = matrix.mean(axis=1)
    chosen: list[tuple[Matrix, Matrix]] = []
    drawn: list[tuple[Matrix, Matrix]] = []
    for held in combinations(range(len(matrix)), min(HELD_OUT, len(matrix) - 1)):
        out = list(held)
        tasks = _chosen(np.delete(matrix, out, axis=0), number)
        chosen.append((matrix[np.ix_(out, tasks)].mean(axis=1), whole[out]))
        for _ in range(_DRAWS):
            some = generator.choice(matrix.shape[1], min(number, matrix.shape[1]), replace=False)
            drawn.append((matrix[np.ix_(out, some)].mean(axis=1), whole[out]))
    return Validity(_fidelity(chosen), _fidelity(drawn))


def _fidelity(tests: Sequence[tuple[Matrix, Matrix]]) -> Fidelity:
    """Of scores in short tests and in the whole suite."""
    ordered = [each for short, whole in tests for each in _ordered(short, whole)]
    squares = [float(each) ** 2 for short, whole in tests for each in short - whole]
    return Fidelity(Rate(sum(ordered), len(ordered)), 100 * math.sqrt(fmean(squares)))


def _ordered(short: Matrix, whole: Matrix) -> Iterator[float]:
    """For each pair of models that differ in the whole suite whether they are in the same order."""
    for one, other in combinations(range(len(whole)), 2):
        if whole[one] != whole[other]:
            ahead = short[one] - short[other]
            yield 0.5 if ahead == 0 else float((ahead > 0) == (whole[one] > whole[other]))


if __name__ == "__main__":
    main()
