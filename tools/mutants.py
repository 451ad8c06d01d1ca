"""Do the tests notice when the core is wrong? A seeded sample of mutants, each tested by its module's tests.

    python tools/mutants.py --number 50 --seed 3
    python tools/mutants.py --only world/past --only extensions/questions/

A mutant is a module with one small change: a comparison, an operator or a connective is another one, a number
is one more, a condition is negated. Left alone are annotations, decorators, which say whether instances have
slots, what is imported for types alone, ``strict`` of `zip`, which says what holds already, and what a random
float is compared with, as it is never just that. The mutant lies in a copy of the sources, in which run,
until one notices something, the tests of its package, its own file's first, then tests elsewhere that import
the module and those of the households, where its callers meet real data: quick ones before slow ones, and
first what noticed other mutants (``tools/quick_first.py``), as many as fit into
``--seconds`` each time. It is the default set of
tests, or with ``--whole`` all. The tests of every package run once on the sources as they are before, which
says how long each takes, unless a file given with ``--known`` has that from another time. Prints what becomes
of each mutant, and how many are noticed; exits with status 1 if those are fewer than nine in ten. Survivors
that no test can notice, since they mean the same, are listed in `EQUIVALENT`, with the reason.
"""

from __future__ import annotations

import argparse
import ast
import math
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = (
    "world",
    "logic",
    "abilities",
    "results",
    "scoring",
    "envs",
    "questions",
    "generator",
)
WANTED = 0.9
SECONDS, WAITS = 300, 10
"""CPU seconds that one run of tests may take, and how often that on the clock; a mutant that takes longer
is noticed."""

_SWAPPED = (
    (ast.Eq, ast.NotEq),
    (ast.Lt, ast.LtE),
    (ast.Gt, ast.GtE),
    (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn),
    (ast.And, ast.Or),
    (ast.Add, ast.Sub),
    (ast.BitAnd, ast.BitOr),
    (ast.LShift, ast.RShift),
)
OTHER: dict[type[ast.AST], type[ast.AST]] = {**dict(_SWAPPED), **{b: a for a, b in _SWAPPED}}
"""What stands in the place of what."""


EQUIVALENT: dict[str, str] = {
    "abilities/subgoal_decomposition/uniform_cost.py: 0 is 1 in `self._pushed = 0`": "only the order of "
    "numbers counts",
    "benchmarks/generator/scene.py: 1 is 2 in `ranked[category] = ranked.get(category, -1) + 1`, place 2": ""
    "only the order of ranks counts",
    "abilities/plan_repairer.py: 1 is 2 in "
    "`rank = names.index(action.operator) if action is not None else -1`": "it comes before all places",
    "logic/choice.py: Lt is LtE in `if weight and not taken >> place & 1 and taken.bit_count() < count:`": ""
    "more than are counted are not summed up in the end",
    "logic/ltl.py: 0 is 1 in `self._stack.append(_Pending(PREFIX, make, [], 0, self._scope))`": "a "
    "quantifier has one part, and that has one level at least",
    "results/certainty.py: 0 is 1 in `if len(known[0]) < len(parts):`": "what is of no task is of no name",
    "results/comparison.py: GtE is Gt in `extreme += _distance(one, other) >= observed - _ROUNDING`": "no "
    "distance is less than the observed one by just this rounding",
    "extensions/questions/shortcuts.py: 0 is 1 in `if step <= 0:`": "what a question adds to a "
    "balance is a multiple of four, and so is the square",
    "tasks/rules.py: without if isinstance(each, Add | Delete) in `atoms = [each.atom for each in run "
    "if isinstance(each, Add | Delete)]`": "a run is of one type, and the condition says so to the type "
    "checker",
}
"""A mutant, as it is printed but for the number of its line -> why it means the same."""


class Mutant(NamedTuple):
    """A module in which one node is changed: of those in a line that change so, the one at this place."""

    path: Path
    node: int
    line: int
    change: str
    source: str
    place: int = 1

    def __str__(self) -> str:
        return f"{self.path.as_posix()}:{self.line}: {self._what}"

    @property
    def name(self) -> str:
        """What it is called, wherever in its module its line has come to stand."""
        return f"{self.path.as_posix()}: {self._what}"

    @property
    def _what(self) -> str:
        return f"{self.change} in `{self.source}`" + (f", place {self.place}" if self.place > 1 else "")

    def text(self) -> str:
        """The module."""
        tree = _parsed(self.path)
        _change(next(node for number, node in enumerate(ast.walk(tree)) if number == self.node))
        return ast.unparse(ast.fix_missing_locations(tree))


def mutants(path: Path) -> Iterator[Mutant]:
    """All mutants of a module."""
    tree, lines = _parsed(path), _text(path).splitlines()
    before: Counter[tuple[int, str]] = Counter()
    idle = {id(part) for node in ast.walk(tree) for each in _idle(node) for part in ast.walk(each)}
    for number, node in enumerate(ast.walk(tree)):
        # A change comes when the node's parts are in line to be visited.
        if id(node) not in idle and (change := _change(node)) is not None:
            place = node.target if isinstance(node, ast.comprehension) else node
            line = getattr(place, "lineno", 0)
            before[line, change] += 1
            yield Mutant(path, number, line, change, lines[line - 1].strip(), before[line, change])


def _idle(node: ast.AST) -> Iterator[ast.AST]:
    """The parts of a node that say nothing of what is done."""
    match node:
        case ast.arg(annotation=ast.AST() as annotation) | ast.AnnAssign(annotation=annotation):
            yield annotation
        case ast.FunctionDef(returns=ast.AST() as annotation):
            yield annotation
        case ast.ClassDef(decorator_list=decorators):
            yield from decorators
        case ast.If(test=ast.Name("TYPE_CHECKING")):
            yield node
        case ast.Call(func=ast.Name("zip"), keywords=[ast.keyword("strict") as strict]):
            yield strict


def _parsed(path: Path) -> ast.Module:
    return ast.parse(_text(path))


def _text(path: Path) -> str:
    return (ROOT / "src" / "eai" / path).read_text(encoding="utf-8")


def _change(node: ast.AST) -> str | None:
    """Change a node, and say how; None where there is nothing to change."""
    match node:
        case ast.Compare(left=ast.Call(func=ast.Attribute(attr="random")), ops=[ast.Lt()]):
            return None
        case ast.Compare(ops=[op, *rest]) if type(op) in OTHER:
            node.ops = [OTHER[type(op)](), *rest]  # type: ignore[list-item]
            return f"{type(op).__name__} is {type(node.ops[0]).__name__}"
        case ast.BoolOp(op=op) | ast.BinOp(op=op) if type(op) in OTHER:
            node.op = OTHER[type(op)]()  # type: ignore[assignment]
            return f"{type(op).__name__} is {type(node.op).__name__}"
        case ast.Constant(value=bool(value)):
            node.value = not value
            return f"{value} is {not value}"
        case ast.Constant(value=int(value)):
            node.value = value + 1
            return f"{value} is {value + 1}"
        case ast.If(test=test) | ast.IfExp(test=test) | ast.While(test=test):
            node.test = ast.UnaryOp(ast.Not(), test)
            return f"if not {ast.unparse(test)}"
        case ast.comprehension(ifs=[test, *rest]):
            node.ifs = rest
            return f"without if {ast.unparse(test)}"
    return None


@dataclass(frozen=True)
class Trial:
    """How mutants are tested.

    Attributes:
        folder: where the copy of the sources lies, and what is known of tests.
        seconds: CPU seconds for the tests nearby, and again for those elsewhere.
        whole: whether with sweeps and all examples of properties, which the default set of tests leaves out.
    """

    folder: Path
    seconds: float
    whole: bool

    @property
    def known(self) -> Path:
        """What is known of tests."""
        return self.folder / "known.json"

    def is_noticed(self, mutant: Mutant) -> bool:
        """Whether a test fails on a mutant, put into the copy of the sources for that time."""
        place = self.folder / "src" / "eai" / mutant.path
        original = place.read_text(encoding="utf-8")
        place.write_text(mutant.text(), encoding="utf-8")
        try:
            own, near, *elsewhere = _tests_of(mutant.path)
            return not (self.passes(near, first=own) and self.passes([p for some in elsewhere for p in some]))
        finally:
            place.write_text(original, encoding="utf-8")

    def passes(self, tests: Sequence[Path], first: Sequence[Path] = (), limit: int = SECONDS) -> bool:
        """Whether tests pass, as many as there is time for; those of some files come first."""
        names = [each.relative_to(ROOT).as_posix() for each in tests]
        options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "quick_first"]
        chosen = ["--hypothesis-profile=thorough"] if self.whole else ["-m", "not sweep"]
        python = [self.folder / "src", ROOT / "tests", ROOT / "tools"]
        given = {
            "PYTHONPATH": os.pathsep.join(map(str, python)),
            "PYTHONDONTWRITEBYTECODE": "1",  # which is taken for that of a mutant written in the same second
            "QUICK_FIRST": str(self.known),
            "QUICK_SECONDS": str(self.seconds),
            "QUICK_NEAR": os.pathsep.join(each.relative_to(ROOT).as_posix() for each in first),
        }
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *chosen, *names],
            cwd=ROOT,
            env={**os.environ, **given},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
        )
        try:
            return process.wait(WAITS * limit) in (0, 5)  # 5: there are no tests
        except subprocess.TimeoutExpired:
            return False
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # with all that it started
            process.wait()


def _tests_of(path: Path) -> Iterator[list[Path]]:
    """The tests that may meet a module, nearest first: of some, none are there."""
    tests = ROOT / "tests"
    folder = tests / path.parent
    near = folder if folder.is_dir() else tests / path.parts[0]
    yield [own for own in [folder / f"test_{path.name}"] if own.exists()]
    yield [near]
    name = ".".join(["eai", *path.with_suffix("").parts])
    yield [
        file
        for file in sorted(tests.rglob("test_*.py"))
        if near not in file.parents and re.search(rf"\b{name}\b", file.read_text(encoding="utf-8"))
    ]
    yield [tests / "benchmarks"]


def main() -> int:
    """Make mutants and test them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        help="a part of the path of a module, such as world/past; repeat it for several",
    )
    parser.add_argument("--number", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--seconds", type=float, default=20, help="CPU seconds for the tests nearby, and again for others"
    )
    parser.add_argument(
        "--whole", action="store_true", help="with sweeps and all examples, as make test-all has them"
    )
    parser.add_argument("--known", type=Path, help="a file that keeps what is known of tests from run to run")
    arguments = parser.parse_args()
    folder = ROOT / "src" / "eai"
    paths = [p.relative_to(folder) for name in PACKAGES for p in sorted((folder / name).rglob("*.py"))]
    wanted = [p for p in paths if not arguments.only or any(part in p.as_posix() for part in arguments.only)]
    made = [mutant for path in wanted for mutant in mutants(path)]
    made = [mutant for mutant in made if mutant.name not in EQUIVALENT]
    sample = random.Random(arguments.seed).sample(made, min(arguments.number, len(made)))  # noqa: S311
    survivors = 0
    with tempfile.TemporaryDirectory() as temporary:
        shutil.copytree(ROOT / "src", Path(temporary, "src"))
        trial = Trial(Path(temporary), arguments.seconds, arguments.whole)
        known = arguments.known
        if known is not None and known.exists():
            shutil.copy(known, trial.known)
        else:
            for package in sorted({mutant.path.parts[0] for mutant in sample}):
                unbounded = replace(trial, seconds=math.inf)
                if not unbounded.passes([ROOT / "tests" / package], limit=10 * SECONDS):
                    sys.exit(f"tests/{package} does not pass as it is")
        for mutant in sample:
            noticed = trial.is_noticed(mutant)
            survivors += not noticed
            print(f"{'noticed' if noticed else 'survives'}: {mutant}", flush=True)
            if known is not None and trial.known.exists():
                shutil.copy(trial.known, known)
    print(f"{len(sample) - survivors} of {len(sample)} mutants are noticed ({len(made)} can be made)")
    return int(survivors > (1 - WANTED) * len(sample))


if __name__ == "__main__":
    sys.exit(main())
