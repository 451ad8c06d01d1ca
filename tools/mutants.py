"""Measure how many small errors in the code the tests notice.

    python tools/mutants.py --number 50 --seed 3
    python tools/mutants.py --only world/history --only extensions/questions/

A mutant is a module with one small change: another comparison, operator or connective, a number plus one, or
a negated condition. Code without effect on results is never changed: annotations, decorators, imports for
types, ``strict`` of `zip`, and a comparison with a random float. The mutants are a random sample by a seed.

Each mutant is tested in a copy of the sources until a test fails. The tests of its own file come first, then
the tests of its package, then other tests that import the module, then the tests of benchmarks. Among these,
tests run first that are quick or that noticed other mutants (``tools/quick_first.py``), within ``--seconds``
of CPU time. ``--whole`` adds the tests that the default set leaves out. Before the first mutant, the tests of
each package run once on the unchanged sources to measure their times, unless ``--known`` names a file of
times.

The program prints whether each mutant is noticed. Its exit status is 1 if fewer than nine in ten are noticed.
`EQUIVALENT` lists mutants that behave like the original code, with the reason.
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
    "agents",
    "extensions/questions",
    "benchmarks/generator",
)
MIN_NOTICED_RATE = 0.9
MAX_CPU_SECONDS = 300
"""CPU seconds that one run of tests may take. A mutant whose tests take longer counts as noticed."""

MAX_WALL_FACTOR = 10
"""Maximum time on the clock, in multiples of the CPU seconds."""

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
REPLACEMENTS: dict[type[ast.AST], type[ast.AST]] = {**dict(_SWAPPED), **{b: a for a, b in _SWAPPED}}
"""The syntax node that a mutant has instead of another one."""


EQUIVALENT: dict[str, str] = {
    "abilities/subgoal_decomposition/uniform_cost.py: 0 is 1 in `self._pushed = 0`": "only the order of "
    "numbers counts",
    "benchmarks/generator/scene.py: 1 is 2 in `ranked[category] = ranked.get(category, -1) + 1`, place 2": ""
    "only the order of ranks counts",
    "abilities/plan_repairer.py: 1 is 2 in "
    "`rank = names.index(action.operator) if action is not None else -1`": "both come before all indices",
    "logic/choice.py: Lt is LtE in "
    "`if cell_count and not taken >> column & 1 and taken.bit_count() < matching_size:`": ""
    "sums beyond the count are ignored at the end",
    "logic/ltl.py: 0 is 1 in "
    "`self._stack.append(_PartlyParsedSubformula(PREFIX, make, [], 0, self._scope))`": "a "
    "quantifier has one part, and that has one level at least",
    "results/comparison.py: GtE is Gt "
    "in `extreme += _compute_absolute_rate_difference(one, other) >= observed - _ROUNDING`": "no "
    "distance is less than the observed one by just this rounding",
    "extensions/questions/shortcuts.py: 0 is 1 in `if step <= 0:`": "what a question adds to a "
    "balance is a multiple of four, and so is the square",
    "tasks/rules.py: without if isinstance(atom_effect, Add | Delete) in `atoms = [atom_effect.atom for "
    "atom_effect in run if isinstance(atom_effect, Add | Delete)]`": "effects of a run have one type; "
    "the check is for mypy",
}
"""Reasons why mutants behave like the original code, by the name of the mutant (`Mutant.name`)."""


class Mutant(NamedTuple):
    """A module with one changed node of its syntax tree.

    Attributes:
        path: Path of the module below `src/eai`.
        node: Number of the node in the order of `ast.walk`.
        line: Line number of the node.
        change: Description of the change, such as `Lt is LtE`.
        source: Source text of the line.
        place: Number of this change among equal changes in its line, from 1.
    """

    path: Path
    node: int
    line: int
    change: str
    source: str
    place: int = 1

    def __str__(self) -> str:
        return f"{self.path.as_posix()}:{self.line}: {self._description}"

    @property
    def name(self) -> str:
        """The description of the mutant without its line number, which other edits would change."""
        return f"{self.path.as_posix()}: {self._description}"

    @property
    def _description(self) -> str:
        return f"{self.change} in `{self.source}`" + (f", place {self.place}" if self.place > 1 else "")

    def text(self) -> str:
        """Return the source of the changed module."""
        tree = _parse_file(self.path)
        _change(next(node for number, node in enumerate(ast.walk(tree)) if number == self.node))
        return ast.unparse(ast.fix_missing_locations(tree))


def make_mutants(path: Path) -> Iterator[Mutant]:
    """Yield all mutants of a module."""
    tree, lines = _parse_file(path), _read_text(path).splitlines()
    before: Counter[tuple[int, str]] = Counter()
    kept = {
        id(node)
        for parent in ast.walk(tree)
        for root in _find_unchanged_nodes(parent)
        for node in ast.walk(root)
    }
    for number, node in enumerate(ast.walk(tree)):
        # `ast.walk` has already queued the parts of this node, so changing the node here is safe.
        if id(node) not in kept and (change := _change(node)) is not None:
            located = node.target if isinstance(node, ast.comprehension) else node
            line = getattr(located, "lineno", 0)
            before[line, change] += 1
            yield Mutant(path, number, line, change, lines[line - 1].strip(), before[line, change])


def _find_unchanged_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the parts of a node that have no effect on results."""
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


def _parse_file(path: Path) -> ast.Module:
    return ast.parse(_read_text(path))


def _read_text(path: Path) -> str:
    return (ROOT / "src" / "eai" / path).read_text(encoding="utf-8")


def _change(node: ast.AST) -> str | None:
    """Change a node and return a description of the change, or None if the node has no change."""
    match node:
        case ast.Compare(left=ast.Call(func=ast.Attribute(attr="random")), ops=[ast.Lt()]):
            return None
        case ast.Compare(ops=[op, *rest]) if type(op) in REPLACEMENTS:
            node.ops = [REPLACEMENTS[type(op)](), *rest]  # type: ignore[list-item]
            return f"{type(op).__name__} is {type(node.ops[0]).__name__}"
        case ast.BoolOp(op=op) | ast.BinOp(op=op) if type(op) in REPLACEMENTS:
            node.op = REPLACEMENTS[type(op)]()  # type: ignore[assignment]
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
    """A way to test mutants.

    Attributes:
        folder: Folder of the copied sources and of the file with times and failures of tests.
        seconds: CPU seconds for the tests of the module's package, and again for all other tests.
        whole: Whether sweeps and all examples of properties run, which the default set leaves out.
    """

    folder: Path
    seconds: float
    whole: bool

    @property
    def history(self) -> Path:
        """The file with times and failures of tests."""
        return self.folder / "known.json"

    def is_noticed(self, mutant: Mutant) -> bool:
        """Whether a test fails on a mutant. The copied sources contain the mutant meanwhile."""
        module = self.folder / "src" / "eai" / mutant.path
        original = module.read_text(encoding="utf-8")
        module.write_text(mutant.text(), encoding="utf-8")
        try:
            own, near, *elsewhere = _find_tests_by_distance(mutant.path)
            return not (
                self.passes(near, first=own) and self.passes([p for files in elsewhere for p in files])
            )
        finally:
            module.write_text(original, encoding="utf-8")

    def passes(self, tests: Sequence[Path], first: Sequence[Path] = (), limit: int = MAX_CPU_SECONDS) -> bool:
        """Whether tests pass. Tests of the files in `first` run first; the time limit can leave tests out."""
        names = [path.relative_to(ROOT).as_posix() for path in tests]
        options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "quick_first"]
        selection = ["--hypothesis-profile=thorough"] if self.whole else ["-m", "not sweep"]
        python = [self.folder / "src", ROOT / "tests", ROOT / "tools"]
        variables = {
            "PYTHONPATH": os.pathsep.join(map(str, python)),
            "PYTHONDONTWRITEBYTECODE": "1",  # Python reuses bytecode of a mutant of the same second
            "QUICK_FIRST": str(self.history),
            "QUICK_SECONDS": str(self.seconds),
            "QUICK_NEAR": os.pathsep.join(path.relative_to(ROOT).as_posix() for path in first),
        }
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *selection, *names],
            cwd=ROOT,
            env={**os.environ, **variables},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
        )
        try:
            return process.wait(MAX_WALL_FACTOR * limit) in (0, 5)  # 5: no test exists
        except subprocess.TimeoutExpired:
            return False
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # and its child processes
            process.wait()


def _find_tests_by_distance(path: Path) -> Iterator[list[Path]]:
    """Yield test files and folders by distance: of the module, its package, its importers, benchmarks."""
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
    """Test a sample of mutants and print the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        help="text in the paths of modules, such as world/history; repeat it for several",
    )
    parser.add_argument("--number", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--seconds", type=float, default=20, help="CPU seconds for tests of the package, and again for others"
    )
    parser.add_argument(
        "--whole", action="store_true", help="also run sweeps and all examples, as make test-all does"
    )
    parser.add_argument("--known", type=Path, help="file that keeps times and failures of tests between runs")
    arguments = parser.parse_args()
    folder = ROOT / "src" / "eai"
    paths = [p.relative_to(folder) for name in PACKAGES for p in sorted((folder / name).rglob("*.py"))]
    selected = [
        p for p in paths if not arguments.only or any(text in p.as_posix() for text in arguments.only)
    ]
    made = [mutant for path in selected for mutant in make_mutants(path)]
    made = [mutant for mutant in made if mutant.name not in EQUIVALENT]
    sample = random.Random(arguments.seed).sample(made, min(arguments.number, len(made)))  # noqa: S311
    survivors = 0
    with tempfile.TemporaryDirectory() as temporary:
        shutil.copytree(ROOT / "src", Path(temporary, "src"))
        trial = Trial(Path(temporary), arguments.seconds, arguments.whole)
        history = arguments.known
        if history is not None and history.exists():
            shutil.copy(history, trial.history)
        else:
            for package in sorted({mutant.path.parts[0] for mutant in sample}):
                unbounded = replace(trial, seconds=math.inf)
                if not unbounded.passes([ROOT / "tests" / package], limit=10 * MAX_CPU_SECONDS):
                    sys.exit(f"tests/{package} fails on the unchanged sources: mend it first")
        for mutant in sample:
            noticed = trial.is_noticed(mutant)
            survivors += not noticed
            print(f"{'noticed' if noticed else 'survives'}: {mutant}", flush=True)
            if history is not None and trial.history.exists():
                shutil.copy(trial.history, history)
    print(f"{len(sample) - survivors} of {len(sample)} mutants are noticed ({len(made)} can be made)")
    return int(survivors > (1 - MIN_NOTICED_RATE) * len(sample))


if __name__ == "__main__":
    sys.exit(main())
