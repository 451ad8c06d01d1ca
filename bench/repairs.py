"""Measure for how many failed plans of models the minimum repair is known, and the time to find it.

    python -m bench repairs [HOUSEHOLD] [--number N] [--seed S] [--effort N]

`--number` plans are drawn at random from the plans in ``../shared/oracle`` that can be read and fail. A
repair is exact if its number of edits is proved to be the minimum, and near if the bounds differ by at most
two. A repair that takes more than a CPU second is neither. Times are those of a process of `eai`, in which
garbage collection is rare.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time
from collections.abc import Callable, Iterator
from itertools import islice
from typing import NamedTuple

import eai
from bench.record import add_write_option, write_rows
from bench.result import Figure
from differential.oracle_answers import model_files, oracle_answers, require_oracle
from eai.abilities.repair import DEFAULT_EFFORT
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.benchmarks.registry import PAPER_BENCHMARKS, get_title
from eai.benchmarks.suite import Suite
from eai.results.collector import reduce_garbage_collection

_IN_TIME, _NEAR = 1.0, 2
"""Maximum CPU seconds of a repair that counts; maximum difference of bounds that count as near."""


class _TimedBounds(NamedTuple):
    """The bounds of a plan's repair, and the CPU seconds of the search."""

    at_least: int
    at_most: int | None
    seconds: float

    def is_within(self, edits: int) -> bool:
        """Return whether the bounds differ by at most the given edits and were found in time."""
        return self.at_most is not None and self.at_most - self.at_least <= edits and self.seconds <= _IN_TIME


def _find_failed_plans(suite: Suite) -> Iterator[Callable[[int], Verdict]]:
    """Yield a search for the repair of each plan that can be read and fails, with the given effort."""
    for path in model_files(f"{suite.domain}/{suite.ability}"):
        for answer in oracle_answers(path):
            if answer.task_id in suite.task_ids:
                verdict, _, look_back = suite.scorer(answer.task_id).assess(answer.text)
                if isinstance(verdict, PlanVerdict) and not verdict.success and look_back is not None:
                    yield look_back


def _search_repair(look_back: Callable[[int], Verdict], effort: int) -> _TimedBounds | None:
    """Return the repair of a plan, or None if its task has no repair."""
    begun = time.process_time()
    verdict = look_back(effort)
    seconds = time.process_time() - begun
    repair = verdict.repair if isinstance(verdict, PlanVerdict) else None
    known = repair is not None and repair.why_null is None
    return _TimedBounds(repair.at_least, repair.at_most, seconds) if repair is not None and known else None


def _print(household: str, found: list[_TimedBounds]) -> list[Figure]:
    """Print a line on the repairs of a household, and return its row on the page."""
    exact, near = [sum(each.is_within(edits) for each in found) / len(found) for edits in (0, _NEAR)]
    times = sorted(each.seconds for each in found)
    late = sum(seconds > _IN_TIME for seconds in times)
    print(
        f"{household}: {len(found)} plans, exact {exact:.1%}, within {_NEAR} edits {near:.1%}, "
        f"none known {sum(each.at_most is None for each in found)}, "
        f"median {statistics.median(times):.3f} CPU s, {late} above {_IN_TIME:g} s, dearest {times[-1]:.1f} s"
    )
    shares = [round(100 * share, 1) for share in (exact, near)]
    return [get_title(household), len(found), *shares, round(statistics.median(times), 3)]


def main() -> None:
    """Print for each household how many minimum repairs are known."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("household", nargs="*", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--number", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--effort", type=int, default=DEFAULT_EFFORT)
    add_write_option(parser)
    chosen, rows = parser.parse_args(), []
    require_oracle()
    reduce_garbage_collection()
    for household in chosen.household:
        failed = list(_find_failed_plans(eai.open(household, "action_sequencing")))
        random.Random(chosen.seed).shuffle(failed)  # noqa: S311
        found = filter(None, (_search_repair(look_back, chosen.effort) for look_back in failed))
        rows.append(_print(household, list(islice(found, chosen.number))))
    if chosen.write:
        write_rows("repairs", rows)
