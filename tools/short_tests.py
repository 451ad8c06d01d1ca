"""Write short tests and difficulties from records of many models: `python tools/short_tests.py RECORDS...`.

A short test is a choice of tasks from a suite. The tasks are sorted by their difficulty in the Rasch model,
and taken at equal distances, so easy and difficult tasks have the same proportion as in the suite. A choice
by information about some models orders other models no better than a random choice
(``docs/extensions/adaptive``).

For each suite the program prints two figures about models that had no part in the choice: the percentage of
pairs of models in the order of the full suite, and the distance of scores from the full suite in percentage
points. Both are also printed for random tasks. Difficulties are written only for suites without a planner;
other suites keep their difficulties.
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

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.extensions.adaptive import difficulties as adaptive
from eai.extensions.adaptive import short_tests
from eai.extensions.adaptive.rasch import estimate_ability_variance_between_task_groups, fit_rasch
from eai.extensions.adaptive.study import SuiteScores, collect_scores
from eai.results.lines import group_by_suite
from eai.results.rate import Rate
from eai.studies.records import StudyRecords

SOURCE = Path(__file__).resolve().parents[1] / "src" / "eai"
TESTS = SOURCE / "extensions" / "adaptive" / short_tests.FILE
DIFFICULTIES = SOURCE / "extensions" / "adaptive" / adaptive.FILE

Matrix: TypeAlias = NDArray[np.float64]

TASKS = 40
"""Number of tasks in a short test."""

HELD_OUT = 4
"""Number of models that are left out of a choice in cross-validation."""

_RANDOM_TESTS = 10
"""Number of random short tests for each set of held-out models."""


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    answers = StudyRecords(tuple(map(Path, sys.argv[1:]))).make_tidy_tables_of_comparable_runs().answers
    tests: dict[str, list[str]] = _read(TESTS)
    difficulties: dict[str, dict[str, Any]] = _read(DIFFICULTIES)
    for suite, suite_answers in group_by_suite(answers).items():
        if suite.protocol != DEFAULT_PROTOCOL.value:
            sys.exit(f"expected records under {DEFAULT_PROTOCOL.value}, not {suite.protocol}")
        scores = collect_scores(suite_answers)
        validity = cross_validate(scores)
        name = f"{suite.domain}/{Ability(suite.ability).value}"
        tests[name] = list(choose(scores))
        if get_declaration(Ability(suite.ability)).answers_are_plans:
            difficulties[name] = fit_difficulties(scores)
        models = f"{len(scores.models)} models"
        chosen, drawn = (
            f"{fidelity.ordered.percent:.1f} {fidelity.distance:.1f}"
            for fidelity in (validity.chosen, validity.drawn)
        )
        print(f"{name:40} {models}  chosen {chosen}  drawn {drawn}", flush=True)
    for file, content in ((TESTS, tests), (DIFFICULTIES, difficulties)):
        text = json.dumps(dict(sorted(content.items())), indent=1)
        file.write_text(text + "\n", encoding="utf-8")


def fit_difficulties(scores: SuiteScores) -> dict[str, Any]:
    """Return each task's difficulty relative to the models' mean ability, and the variance between titles."""
    fitted = fit_rasch(scores.matrix)
    shifted = fitted.difficulties - fitted.abilities.mean()
    return {
        "variance_between_names": round(
            estimate_ability_variance_between_task_groups(scores.matrix, fitted, scores.names), 3
        ),
        "difficulties": {
            task: round(float(value), 3) for task, value in zip(scores.tasks, shifted, strict=True)
        },
    }


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def choose(scores: SuiteScores, number: int = TASKS) -> tuple[str, ...]:
    """Return the tasks of a short test in the order of the suite, or all tasks of a smaller suite."""
    chosen = set(_choose_columns(scores.matrix, number))
    return tuple(task for column, task in enumerate(scores.tasks) if column in chosen)


def _choose_columns(matrix: Matrix, number: int) -> list[int]:
    difficulties = fit_rasch(matrix).difficulties
    order = sorted(range(len(difficulties)), key=lambda task: (round(float(difficulties[task]), 9), task))
    if len(order) <= number:
        return order
    return [order[(2 * step + 1) * len(order) // (2 * number)] for step in range(number)]


@dataclass(frozen=True, slots=True)
class Fidelity:
    """Agreement of short tests with the full suite.

    Attributes:
        ordered: Rate of pairs of models in the order of the full suite; a tie counts one half.
        distance: Root mean squared difference of a model's scores in short test and full suite, in
            percentage points.
    """

    ordered: Rate
    distance: float


@dataclass(frozen=True, slots=True)
class Validity:
    """Agreement of short tests with the full suite for models that had no part in the choice of tasks.

    Attributes:
        chosen: Agreement of the tasks that the other models chose.
        drawn: Agreement of random tasks, the same number.
    """

    chosen: Fidelity
    drawn: Fidelity


def cross_validate(scores: SuiteScores, number: int = TASKS) -> Validity:
    """Return the validity of short tests over all ways to hold out `HELD_OUT` models."""
    matrix, generator = scores.matrix, np.random.default_rng(0)
    full = matrix.mean(axis=1)
    chosen: list[tuple[Matrix, Matrix]] = []
    drawn: list[tuple[Matrix, Matrix]] = []
    for held in combinations(range(len(matrix)), min(HELD_OUT, len(matrix) - 1)):
        out = list(held)
        tasks = _choose_columns(np.delete(matrix, out, axis=0), number)
        chosen.append((matrix[np.ix_(out, tasks)].mean(axis=1), full[out]))
        for _ in range(_RANDOM_TESTS):
            columns = generator.choice(matrix.shape[1], min(number, matrix.shape[1]), replace=False)
            drawn.append((matrix[np.ix_(out, columns)].mean(axis=1), full[out]))
    return Validity(_compute_fidelity(chosen), _compute_fidelity(drawn))


def _compute_fidelity(tests: Sequence[tuple[Matrix, Matrix]]) -> Fidelity:
    ordered = [credit for short, full in tests for credit in _compare_order(short, full)]
    squares = [float(difference) ** 2 for short, full in tests for difference in short - full]
    return Fidelity(Rate(sum(ordered), len(ordered)), 100 * math.sqrt(fmean(squares)))


def _compare_order(short: Matrix, full: Matrix) -> Iterator[float]:
    """Yield 1, 0.5 for a tie or 0 for each pair of models that differ in the full suite."""
    for one, other in combinations(range(len(full)), 2):
        if full[one] != full[other]:
            difference = short[one] - short[other]
            yield 0.5 if difference == 0 else float((difference > 0) == (full[one] > full[other]))


if __name__ == "__main__":
    main()
