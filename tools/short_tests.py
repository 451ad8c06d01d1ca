"""Writes the short tests from records of many models: `python tools/short_tests.py RECORDS...`.

Prints for each suite how many percent of the pairs of models that had no part in choosing are in the order
of the whole suite: for the chosen tasks, and for as many that are drawn at random.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from eai.abilities.protocol import Ability
from eai.analysis.items import scores_of
from eai.analysis.short_test import choose, cross_validate
from eai.analysis.suites import by_suite
from eai.benchmarks.short_tests import FILE
from eai.benchmarks.suite import DEFAULT_PROTOCOL
from eai.cli.analyzed import tables_of

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    answers = tables_of(map(Path, sys.argv[1:]), None).answers
    tests: dict[str, list[str]] = {}
    for suite, of_suite in by_suite(answers).items():
        if suite.protocol != DEFAULT_PROTOCOL.value:
            sys.exit(f"expected records under {DEFAULT_PROTOCOL.value}, not {suite.protocol}")
        scores = scores_of(of_suite)
        found = cross_validate(scores)
        name = f"{suite.domain}/{Ability(suite.ability).value}"
        tests[name] = list(choose(scores))
        models = f"{len(scores.models)} models"
        print(f"{name:40} {models} {found.chosen.percent:.1f} {found.drawn.percent:.1f}", flush=True)
    path = ROOT / "src" / "eai" / "benchmarks" / FILE
    path.write_text(json.dumps(dict(sorted(tests.items())), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
