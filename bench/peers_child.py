"""Measure other libraries on the work of `peers.py`, and print processor milliseconds as JSON.

It runs in a separate environment with `unified-planning`, `pyperplan`, `textworld[pddl]` and `flloat`.
Standard input has the work: files of a domain and a problem, a plan, a formula and a trace. Reading and
grounding do not count, except in TextWorld, which starts each game from its files.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def measure_milliseconds(work: Callable[[], object]) -> float:
    """Return the minimum processor time of five runs in milliseconds. The first runs also fill caches."""
    found = []
    for _ in range(5):
        start = time.process_time()
        work()
        found.append(1000 * (time.process_time() - start))
    return min(found)


def require_valid(found: bool) -> None:
    """Raise if a library rejects the plan, which is valid."""
    if not found:
        raise SystemExit("a library judged the valid plan invalid")


def make_validation(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Return a run of unified-planning's validator of sequential plans on a parsed plan."""
    from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
    from unified_planning.io import PDDLReader

    reader = PDDLReader()
    opened = reader.parse_problem(domain, problem)
    steps = reader.parse_plan_string(opened, plan)
    validator = SequentialPlanValidator()
    return lambda: require_valid(validator.validate(opened, steps).status is ValidationResultStatus.VALID)


def make_replay(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Return a run of pyperplan's ground operators, applied one after another."""
    from pyperplan.planner import _ground, _parse

    task = _ground(_parse(domain, problem))
    by_name = {operator.name: operator for operator in task.operators}
    steps = plan.splitlines()

    def replay() -> None:
        state = task.initial_state
        for step in steps:
            operator = by_name[step]
            require_valid(operator.applicable(state))
            state = operator.apply(state)
        require_valid(task.goal_reached(state))

    return replay


PLACES = {"?from": "?here", "?to": "?there"}
"""New names for parameters that are keywords of Python, because TextWorld evaluates parameters."""

GRAMMAR = """
grammar :: \"\"\"{"intro": [{"rhs": "A ferry."}], "done": [{"rhs": "Done."}]}\"\"\";
action sail { template :: "sail {here} {there}"; feedback :: "#done#"; }
action board { template :: "board {v} {h}"; feedback :: "#done#"; }
action debark { template :: "debark {v} {h}"; feedback :: "#done#"; }
"""


def make_game_run(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Return a run of TextWorld's engine: each step is a command, answered with the possible commands."""
    import textworld
    from textworld.envs import PddlEnv

    text = Path(domain).read_text()
    for name, other in PLACES.items():
        text = text.replace(name, other)
    game = PddlEnv(textworld.EnvInfos())
    game.load({"pddl_domain": text, "grammar": GRAMMAR, "pddl_problem": Path(problem).read_text()})
    commands = [step.strip("()") for step in plan.splitlines()]

    def play() -> None:
        game.reset()
        won = False
        for command in commands:
            _, _, won = game.step(command)
        require_valid(won)

    return play


def make_evaluation(formula: str, trace: list[dict[str, bool]]) -> Callable[[], object]:
    """Return a run of flloat's evaluation of a formula on a finite trace."""
    from flloat.parser.ltlf import LTLfParser

    parsed = LTLfParser()(formula)
    return lambda: parsed.truth(trace)


def main() -> None:
    asked: dict[str, Any] = json.load(sys.stdin)
    works = {
        "unified-planning": make_validation(asked["domain"], asked["problem"], asked["plan"]),
        "pyperplan": make_replay(asked["domain"], asked["problem"], asked["plan"]),
        "TextWorld": make_game_run(asked["domain"], asked["problem"], asked["plan"]),
        "flloat": make_evaluation(asked["formula"], asked["trace"]),
    }
    print(json.dumps({name: measure_milliseconds(work) for name, work in works.items()}))


if __name__ == "__main__":
    main()
