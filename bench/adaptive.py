"""Measure how many tasks `eai run --adaptive` asks, and its distance from the whole suite's ability.

    python -m bench adaptive RECORDS...

RECORDS are records of many models under ``strict`` (action sequencing, subgoal decomposition). Each model is
held out in turn: the other models determine the difficulty of tasks, and the model's own records answer the
adaptive run. For comparison, the table has the number of tasks that random order needs for the same standard
error.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Callable, Mapping
from math import sqrt
from pathlib import Path
from statistics import fmean, median
from typing import NamedTuple

import numpy as np

from bench.record import add_write_option, get_suite_title, write_rows
from bench.result import Figure
from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability
from eai.extensions.adaptive.difficulties import choose_most_informative_tasks, estimate_ability
from eai.extensions.adaptive.rasch import estimate_ability_variance_between_task_groups, fit_rasch
from eai.extensions.adaptive.runs import TASKS_PER_ROUND
from eai.extensions.adaptive.study import SuiteScores, collect_scores
from eai.results.lines import group_by_suite
from eai.studies.records import StudyRecords

TARGETS = (0.5, 0.4, 0.3)
DRAWS = 5

Numbers = Mapping[str, float]
Choose = Callable[[Numbers], tuple[str, ...]]


def main() -> None:
    """Print a line for each suite and each target of the standard error."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("records", type=Path, nargs="+")
    add_write_option(parser)
    arguments, rows = parser.parse_args(), list[list[Figure]]()
    answers = StudyRecords(tuple(arguments.records)).make_tidy_tables_of_comparable_runs().answers
    print("suite, standard error: tasks asked (least, most), in random order; distance; within 1.96 errors")
    for suite, of_suite in group_by_suite(answers).items():
        if get_declaration(Ability(suite.ability)).answers_are_plans:
            for target in TARGETS:
                asked, at_random, distance, within = measure_target(collect_scores(of_suite), target)
                print(f"{suite}, {target}: {asked}, {at_random}; {distance}; {within}", flush=True)
                rows.append(
                    [get_suite_title(suite.domain, suite.ability), target, asked, at_random, distance]
                )
    if arguments.write:
        write_rows("adaptive", rows, table=1, keys=2)


def measure_target(scores: SuiteScores, target: float) -> tuple[str, int, float, str]:
    """Return the tasks asked, the tasks asked in random order, the distance in ability, and the coverage.

    The figures are means over the held-out models. Coverage is the share of models whose distance is within
    1.96 standard errors.
    """
    names = dict(zip(scores.tasks, scores.names, strict=True))
    sizes, drawn, distances, within = [], [], [], 0
    for held in range(len(scores.models)):
        others = np.delete(scores.matrix, held, axis=0)
        fitted = fit_rasch(others)
        shifted = fitted.difficulties - fitted.abilities.mean()
        difficulties = dict(zip(scores.tasks, map(float, shifted), strict=True))
        own = dict(zip(scores.tasks, map(float, scores.matrix[held]), strict=True))
        variance = estimate_ability_variance_between_task_groups(others, fitted, scores.names)

        def informative(asked: Numbers, difficulties: Numbers = difficulties) -> tuple[str, ...]:
            return choose_most_informative_tasks(TASKS_PER_ROUND, asked, difficulties, names)

        known = HeldOutDifficulties(difficulties, names, variance)
        asked = ask_adaptively(own, known, target, informative)
        (estimated_ability, error), (whole, _) = known.estimate_ability(asked), known.estimate_ability(own)
        sizes.append(len(asked))
        distances.append(estimated_ability - whole)
        within += abs(distances[-1]) <= 1.96 * error
        drawn += [
            len(ask_adaptively(own, known, target, make_random_chooser(own, seed))) for seed in range(DRAWS)
        ]
    distance = sqrt(fmean(each * each for each in distances))
    asked_tasks = f"{median(sizes):.0f} ({min(sizes)}, {max(sizes)})"
    return asked_tasks, round(median(drawn)), round(distance, 2), f"{within}/{len(sizes)}"


class HeldOutDifficulties(NamedTuple):
    """Difficulties of tasks, estimated from the other models' records."""

    difficulties: Numbers
    names: Mapping[str, str]
    variance: float

    def estimate_ability(self, scores: Numbers) -> tuple[float, float]:
        return estimate_ability(scores, self.difficulties, self.names, self.variance)


def ask_adaptively(
    own: Numbers, known: HeldOutDifficulties, target: float, choose: Choose
) -> dict[str, float]:
    """Return the answers of an adaptive run."""
    asked: dict[str, float] = {}
    while len(asked) < len(own) and (not asked or known.estimate_ability(asked)[1] > target):
        asked |= {task: own[task] for task in choose(asked)}
    return asked


def make_random_chooser(own: Numbers, seed: int) -> Choose:
    """Yield tasks one by one in random order."""
    order = random.Random(seed).sample(list(own), len(own))  # noqa: S311 - reproducible, not secret
    return lambda asked: (order[len(asked)],)
