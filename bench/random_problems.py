"""Measure the built-in planner on random problems of five PDDL domains, beside Fast Downward.

    python -m bench random_problems [PROBLEM ...] [--sizes 8 16 32] [--seeds N]

A problem has SIZE blocks, cars, balls, parcels or crates; the number of its places grows with them. The CPU
seconds are those of planning, and for Fast Downward those of its processes, translation included.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import NamedTuple

from bench.record import add_write_option, write_rows
from bench.result import Figure
from eai.benchmarks.registry import find_benchmark
from eai.pddl.fast_downward import FastDownward
from eai.pddl.planning import PlannerOutcome, PlanningTask
from eai.pddl.reader import read_domain, read_problem
from eai.planning.planner import Planner
from eai.planning.search import SearchEndReason
from eai.tasks.planning import find_plan
from eai.tasks.source import Source

_FOLDER = Path(__file__).with_name("domains")
_TEST_DOMAINS = Path(__file__).parents[1] / "tests" / "pddl" / "domains"
_MAX_CPU_SECONDS = 60
"""Maximum CPU seconds of each of the two processes of Fast Downward."""


class RandomProblem(NamedTuple):
    """The parts of a problem: objects by type, initial facts and goals, as atoms without parentheses."""

    objects: Mapping[str, Sequence[str]]
    initial: Sequence[str]
    goals: Sequence[str]

    def format_pddl(self, domain_name: str) -> str:
        """Return the problem as PDDL text."""
        objects = " ".join([f"{' '.join(names)} - {kind}" for kind, names in self.objects.items()])
        if self.objects.keys() == {"object"}:
            objects = " ".join(self.objects["object"])
        initial, goals = (" ".join([f"({atom})" for atom in atoms]) for atoms in (self.initial, self.goals))
        head = f"(define (problem random) (:domain {domain_name})"
        return f"{head}\n(:objects {objects})\n(:init {initial})\n(:goal (and {goals})))\n"


def _make_names(letter: str, number: int) -> list[str]:
    return [f"{letter}{index}" for index in range(number)]


def _pile_up(names: Sequence[str], bases: Sequence[str], rng: Random) -> list[list[str]]:
    """Return a pile on each base. The names lie on the piles in random order."""
    piles = [[base] for base in bases]
    for name in rng.sample(names, len(names)):
        rng.choice(piles).append(name)
    return piles


def _list_pairs_in_piles(piles: Iterable[Sequence[str]]) -> list[str]:
    return [f"on {upper} {lower}" for pile in piles for lower, upper in pairwise(pile)]


def _make_blocks(size: int, rng: Random) -> RandomProblem:
    names = _make_names("b", size)
    towers, wanted = (
        [pile[1:] for pile in _pile_up(names, _make_names("t", size // 3), rng) if pile[1:]] for _ in "01"
    )
    return _make_towers(names, towers, wanted, rng)


def _make_one_tower(size: int, rng: Random) -> RandomProblem:
    names = _make_names("b", size)
    return _make_towers(names, [rng.sample(names, size)], [rng.sample(names, size)], rng)


def _make_reversed_tower(size: int, rng: Random) -> RandomProblem:
    names = _make_names("b", size)
    tower = rng.sample(names, size)
    return _make_towers(names, [tower], [tower[::-1]], rng)


def _make_towers(
    names: Sequence[str], towers: Sequence[Sequence[str]], wanted: Sequence[Sequence[str]], rng: Random
) -> RandomProblem:
    initial = [f"on-table {tower[0]}" for tower in towers] + [f"clear {tower[-1]}" for tower in towers]
    goals = _list_pairs_in_piles(wanted)
    rng.shuffle(goals)
    return RandomProblem({"object": names}, [*initial, *_list_pairs_in_piles(towers), "hand-empty"], goals)


def _make_ferry(size: int, rng: Random) -> RandomProblem:
    cars, places = _make_names("c", size), _make_names("p", size // 4)
    initial = [f"at {car} {rng.choice(places)}" for car in cars]
    return RandomProblem(
        {"car": cars, "place": places},
        [*initial, f"ferry-at {rng.choice(places)}", "ferry-empty"],
        [f"at {car} {rng.choice(places)}" for car in cars],
    )


def _make_gripper(size: int, rng: Random) -> RandomProblem:
    balls, rooms = _make_names("b", size), ["here", "there"]
    return RandomProblem(
        {"ball": balls, "room": rooms},
        [*[f"in {ball} here" for ball in balls], "robot-in here", "free left", "free right"],
        [f"in {ball} there" for ball in rng.sample(balls, size)],
    )


def _make_logistics(size: int, rng: Random) -> RandomProblem:
    cities, parcels = _make_names("c", size // 4), _make_names("p", size)
    airports = [f"{city}-airport" for city in cities]
    others = [f"{city}-{name}" for city in cities for name in ("north", "south")]
    trucks, aeroplanes = [f"{city}-truck" for city in cities], _make_names("a", max(1, size // 16))
    places = [*airports, *others]
    initial = [f"part-of {place} {place.split('-')[0]}" for place in places]
    initial += [f"at {city}-truck {city}-north" for city in cities]
    initial += [f"at {vehicle} {rng.choice(airports)}" for vehicle in aeroplanes]
    return RandomProblem(
        {
            "city": cities,
            "airport": airports,
            "place": others,
            "parcel": parcels,
            "truck": trucks,
            "aeroplane": aeroplanes,
        },
        [*initial, *[f"at {parcel} {rng.choice(places)}" for parcel in parcels]],
        [f"at {parcel} {rng.choice(places)}" for parcel in parcels],
    )


def _make_depot(size: int, rng: Random) -> RandomProblem:
    number, trucks, crates = max(2, size // 4), ["t0", "t1"], _make_names("c", size)
    places, hoists, pallets = (_make_names(letter, number) for letter in ("p", "h", "s"))
    piles, wanted = (_pile_up(crates, pallets, rng) for _ in "01")
    initial = [f"truck-at {truck} {rng.choice(places)}" for truck in trucks]
    for place, hoist, pile in zip(places, hoists, piles, strict=True):
        initial += [f"hoist-at {hoist} {place}", f"free {hoist}", f"clear {pile[-1]}"]
        initial += [f"at {surface} {place}" for surface in pile]
    return RandomProblem(
        {"truck": trucks, "hoist": hoists, "place": places, "pallet": pallets, "crate": crates},
        [*initial, *_list_pairs_in_piles(piles)],
        _list_pairs_in_piles(wanted),
    )


MAKERS: Mapping[str, tuple[Path, Callable[[int, Random], RandomProblem]]] = {
    "blocks": (_TEST_DOMAINS / "blocksworld" / "domain.pddl", _make_blocks),
    "one tower": (_TEST_DOMAINS / "blocksworld" / "domain.pddl", _make_one_tower),
    "reversed tower": (_TEST_DOMAINS / "blocksworld" / "domain.pddl", _make_reversed_tower),
    "ferry": (_FOLDER / "ferry.pddl", _make_ferry),
    "gripper": (_FOLDER / "gripper.pddl", _make_gripper),
    "logistics": (_TEST_DOMAINS / "logistics" / "domain.pddl", _make_logistics),
    "depot": (_FOLDER / "depot.pddl", _make_depot),
}
"""Domain file and function that makes a problem, by name of the kind of problem."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("problems", nargs="*", metavar="PROBLEM", help=f"of {', '.join(MAKERS)}; all if none")
    parser.add_argument("--sizes", type=int, nargs="+", default=[8, 16, 32])
    parser.add_argument("--seeds", type=int, default=1, help="number of problems of a kind and size")
    add_write_option(parser)
    arguments = parser.parse_args()
    if unknown := set(arguments.problems) - MAKERS.keys():
        parser.error(f"unknown problems: {', '.join(sorted(unknown))}")
    rows = []
    for name in arguments.problems or MAKERS:
        for size in arguments.sizes:
            for seed in range(arguments.seeds):
                rows.append(_measure_problem(name, size, seed))
                print(f"| {' | '.join(map(str, rows[-1]))} |", flush=True)
    if arguments.write:
        write_rows("random_problems", rows)


def _measure_problem(name: str, size: int, seed: int) -> tuple[Figure, ...]:
    """Return the row of a problem: its name, states, CPU seconds, and CPU seconds of Fast Downward."""
    domain_file, make_problem = MAKERS[name]
    domain = read_domain(domain_file.read_text())
    problem_text = make_problem(size, Random(f"{name} {size} {seed}")).format_pddl(domain.name)  # noqa: S311
    with tempfile.TemporaryDirectory() as folder:
        problem_file = Path(folder, "problem.pddl")
        problem_file.write_text(problem_text)
        benchmark = find_benchmark(f"pddl:{domain_file},{problem_file}")
        (task,) = benchmark.tasks(Source()).values()
        start = time.process_time()
        found = find_plan(task, Planner(benchmark.domain))
        seconds = time.process_time() - start
    before = _read_cpu_seconds_of_children()
    other_planner = FastDownward.find_installed(_MAX_CPU_SECONDS)
    other = other_planner.solve(PlanningTask(domain, read_problem(problem_text)))
    other_seconds = _read_cpu_seconds_of_children() - before
    is_solved, is_other_solved = found.end is SearchEndReason.SOLVED, other.outcome is PlannerOutcome.SOLVED
    return (
        f"{name}, {size} (seed {seed})",
        found.states if is_solved else "unsolved",
        round(seconds, 2),
        round(other_seconds, 2) if is_other_solved else f"unsolved, {other_seconds:.0f}",
    )


def _read_cpu_seconds_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
