"""Writes short tests and difficulties from records of many models: `python tools/short_tests.py RECORDS...`.

Prints for each suite how many percent of the pairs of models that had no part in choosing are in the order
of the whole suite, and how many points their scores are from those of the whole suite: for the chosen tasks,
and for as many that are drawn at random. Difficulties are those of
suites whose answers are right or wrong without a planner. What other suites have stays as it is.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability
from eai.benchmark.suite import DEFAULT_PROTOCOL
from eai.cli.analyzed import tables_of
from eai.results.suites import by_suite
from eai.studies.items import adaptive, short_tests
from eai.studies.items.analysis import Scores, scores_of
from eai.studies.items.rasch import fit_rasch, variance_between
from eai.studies.items.short_test import choose, cross_validate

FOLDER = Path(__file__).resolve().parents[1] / "src" / "eai" / "studies" / "items"


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    answers = tables_of(map(Path, sys.argv[1:]), None).answers
    tests: dict[str, list[str]] = _read(short_tests.FILE)
    difficulties: dict[str, dict[str, Any]] = _read(adaptive.FILE)
    for suite, of_suite in by_suite(answers).items():
        if suite.protocol != DEFAULT_PROTOCOL.value:
            sys.exit(f"expected records under {DEFAULT_PROTOCOL.value}, not {suite.protocol}")
        scores = scores_of(of_suite)
        found = cross_validate(scores)
        name = f"{suite.domain}/{Ability(suite.ability).value}"
        tests[name] = list(choose(scores))
        if DECLARATIONS[Ability(suite.ability)].has_plans:
            difficulties[name] = difficulties_of(scores)
        models = f"{len(scores.models)} models"
        chosen, drawn = (
            f"{each.ordered.percent:.1f} {each.distance:.1f}" for each in (found.chosen, found.drawn)
        )
        print(f"{name:40} {models}  chosen {chosen}  drawn {drawn}", flush=True)
    for file, content in ((short_tests.FILE, tests), (adaptive.FILE, difficulties)):
        text = json.dumps(dict(sorted(content.items())), indent=1)
        (FOLDER / file).write_text(text + "\n", encoding="utf-8")


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


def _read(file: str) -> Any:
    path = FOLDER / file
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


if __name__ == "__main__":
    main()
