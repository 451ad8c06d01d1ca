"""Compare the speed on plans, games and formulas with five other libraries.

    python -m bench peers --python PYTHON [--steps 10 100 1000]

PYTHON has `unified-planning`, `pyperplan`, `textworld[pddl]` and `flloat`. The plan belongs to a ferry domain
and has the given number of steps. The formula has ten operators, and its trace has the given number of
states. Three times of `eai` are printed:

- the verdict of `strict` on the text of the answer, with its diagnosis;
- execution of parsed steps, for comparison with the other libraries;
- a game in which each step is a command and each reply lists the possible commands, as TextWorld's do.

VAL is a program that reads its files each time.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from itertools import cycle, islice
from pathlib import Path

from bench.record import add_write_option, write_rows
from bench.result import Figure
from differential.reference_child import cpu_seconds
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.ltl import read_formula
from eai.logic.semantics import holds
from eai.logic.signature import FormulaSignature
from eai.logic.trace import Trace
from eai.pddl.val import find_val_program
from eai.world.action import Action
from eai.world.execution import execute_plan

WORLDS = Path(__file__).parents[1] / "tests" / "worlds"
DOMAIN, PROBLEM = WORLDS / "ferry.pddl", WORLDS / "ferry-1.pddl"
ROUND = ("sail home north", "sail north south", "sail south home")
END = (
    *("sail home north", "board red north", "sail north south", "debark red south", "sail south home"),
    *("board big home", "sail home north", "debark big north"),
)
FORMULA = "G(a -> F b) & (c U d | X X X e) & F G(!f | X g) & G F(h & !i | j)"
OURS = (
    "always (a() implies eventually b()) and (c() until d() or next next next e()) and "
    "eventually always (not f() or next g()) and always eventually (h() and not i() or j())"
)
LETTERS = "abcdefghij"
COLUMNS = (
    *("verdict", "execution", "VAL", "unified-planning", "pyperplan"),
    *("game", "TextWorld", "formula", "flloat"),
)


class Facts:
    """A state of the trace: the true atoms, each a letter."""

    def __init__(self, number: int) -> None:
        self.true = {letter for n, letter in enumerate(LETTERS) if number % (n + 2) == 0}

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        return predicate in self.true

    def list_objects(self, category: str | None) -> Sequence[str]:
        return []


def measure_milliseconds(work: Callable[[], bool]) -> float:
    """Return the minimum processor time of five runs in milliseconds, with the programs that they start.

    All runs must have the same outcome.
    """
    found, outcomes = [], set()
    for _ in range(5):
        start = cpu_seconds()
        outcomes.add(work())
        found.append(1000 * (cpu_seconds() - start))
    (_,) = outcomes
    return min(found)


def succeeds(verdict: Verdict) -> bool:
    return isinstance(verdict, PlanVerdict) and bool(verdict.success)


def require_valid(found: bool) -> bool:
    """Raise unless a plan was judged valid: all plans of this program are."""
    if not found:
        raise SystemExit("a library or eai judged the valid plan invalid")
    return found


def make_plan(length: int) -> list[str]:
    """Return a plan of about the given length that reaches the goal."""
    before = (length - len(END)) // len(ROUND) * len(ROUND)
    return [*islice(cycle(ROUND), max(0, before)), *END]


def measure_judging(steps: list[str]) -> dict[str, float]:
    """Return the milliseconds that `eai` and VAL need to judge a plan."""
    suite = open_suite(find_benchmark(f"pddl:{DOMAIN},{PROBLEM}"), Ability.ACTION_SEQUENCING)
    ((task_id, task),) = suite.tasks.items()
    text = "\n".join(f"({step})" for step in steps)
    scorer, domain = suite.scorer(task_id), suite.benchmark.domain
    place = {each.name: number for number, each in enumerate(task.scene.objects)}
    actions = [
        Action(name, tuple(place[each] for each in objects)) for name, *objects in map(str.split, steps)
    ]
    rules = GameRules(until="done", max_steps=None, feedback="outcome")
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan"
        plan.write_text(text + "\n")
        words = [str(find_val_program()), str(DOMAIN), str(PROBLEM), str(plan)]
        return {
            "verdict": measure_milliseconds(lambda: require_valid(succeeds(scorer.score(text)))),
            "execution": measure_milliseconds(
                lambda: require_valid(execute_plan(domain, task.initial, actions).failure is None)
            ),
            "game": measure_milliseconds(
                lambda: require_valid(wins_game(Game(make_setup(task, suite.benchmark, rules)), actions))
            ),
            "VAL": measure_milliseconds(
                lambda: require_valid("Plan valid" in subprocess.check_output(words, text=True))
            ),
        }


def wins_game(game: Game, actions: Sequence[Action]) -> bool:
    """Return whether commands win a game. Each command is answered with the possible commands."""
    for action in actions:
        game.act(game.setup.commands.write_command(action))
        [game.setup.commands.write_command(each) for each in game.find_possible_actions()]
    return all(game.reached)


def measure_evaluation(length: int) -> dict[str, float]:
    """Return the milliseconds that `eai` needs to evaluate a formula."""
    formula = read_formula(OURS, FormulaSignature(dict.fromkeys(LETTERS, 0), {}))[0]
    states = [Facts(number) for number in range(length)]
    return {"formula": measure_milliseconds(lambda: holds(formula, Trace(states)))}


def measure_others(python: str, steps: list[str]) -> dict[str, float]:
    """Return the milliseconds that the other libraries need, each in the environment of PYTHON."""
    trace = [{letter: letter in Facts(number).true for letter in LETTERS} for number in range(len(steps))]
    work = {"domain": str(DOMAIN), "problem": str(PROBLEM), "formula": FORMULA, "trace": trace}
    work["plan"] = "\n".join(f"({step})" for step in steps)
    child = [python, str(Path(__file__).with_name("peers_child.py"))]
    done = subprocess.run(child, input=json.dumps(work), capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--python", required=True)
    parser.add_argument("--steps", type=int, nargs="+", default=[10, 100, 1_000])
    add_write_option(parser)
    arguments, rows = parser.parse_args(), list[list[Figure]]()
    print(f"| steps | {' | '.join(COLUMNS)} |\n{'|---:' * (1 + len(COLUMNS))}|")
    for length in arguments.steps:
        steps = make_plan(length)
        took = {
            **measure_judging(steps),
            **measure_evaluation(len(steps)),
            **measure_others(arguments.python, steps),
        }
        cells = [f"{took[name]:.3g}" for name in COLUMNS]
        rows.append([len(steps), *cells])
        print(f"| {len(steps)} | {' | '.join(cells)} |", flush=True)
    if arguments.write:
        write_rows("peers", rows)
