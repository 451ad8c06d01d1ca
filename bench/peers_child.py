"""What other libraries take for the work of `peers.py`: processor milliseconds of each, printed as JSON.

It runs in an environment of its own with `unified-planning`, `pyperplan`, `textworld[pddl]` and `flloat`.
Standard input has the work: files of a domain and a problem, a plan, a formula and a trace. Reading and
grounding are not counted, but for TextWorld's, which begins a game anew each time.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def milliseconds(work: Callable[[], object]) -> float:
    """The least processor time of five runs, of which the first ones make what is made once."""
    found = []
    for _ in range(5):
        start = time.process_time()
        work()
        found.append(1000 * (time.process_time() - start))
    return min(found)


def valid(found: bool) -> None:
    """Say where a plan is refused, which is valid."""
    if not found:
        raise SystemExit("a valid plan was refused")


def validating(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Its validator of sequential plans, on a plan that is read before."""
    from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
    from unified_planning.io import PDDLReader

    reader = PDDLReader()
    opened = reader.parse_problem(domain, problem)
    steps = reader.parse_plan_string(opened, plan)
    validator = SequentialPlanValidator()
    return lambda: valid(validator.validate(opened, steps).status is ValidationResultStatus.VALID)


def replaying(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Its grounded operators, applied one after another."""
    from pyperplan.planner import _ground, _parse

    task = _ground(_parse(domain, problem))
    by_name = {operator.name: operator for operator in task.operators}
    steps = plan.splitlines()

    def replay() -> None:
        state = task.initial_state
        for step in steps:
            operator = by_name[step]
            valid(operator.applicable(state))
            state = operator.apply(state)
        valid(task.goal_reached(state))

    return replay


PLACES = {"?from": "?here", "?to": "?there"}
"""Parameters that are words of Python, by names that are none: TextWorld evaluates them."""

GRAMMAR = """
grammar :: \"\"\"{"intro": [{"rhs": "A ferry."}], "done": [{"rhs": "Done."}]}\"\"\";
action sail { template :: "sail {here} {there}"; feedback :: "#done#"; }
action board { template :: "board {v} {h}"; feedback :: "#done#"; }
action debark { template :: "debark {v} {h}"; feedback :: "#done#"; }
"""


def playing(domain: str, problem: str, plan: str) -> Callable[[], object]:
    """Its engine for games in PDDL: a plan as commands, each answered with the commands that are possible."""
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
        valid(won)

    return play


def evaluating(formula: str, trace: list[dict[str, bool]]) -> Callable[[], object]:
    """Its truth of a formula on a finite trace."""
    from flloat.parser.ltlf import LTLfParser

    parsed = LTLfParser()(formula)
    return lambda: parsed.truth(trace)


def main() -> None:
    asked: dict[str, Any] = json.load(sys.stdin)
    works = {
        "unified-planning": validating(asked["domain"], asked["problem"], asked["plan"]),
        "pyperplan": replaying(asked["domain"], asked["problem"], asked["plan"]),
        "TextWorld": playing(asked["domain"], asked["problem"], asked["plan"]),
        "flloat": evaluating(asked["formula"], asked["trace"]),
    }
    print(json.dumps({name: milliseconds(work) for name, work in works.items()}))


if __name__ == "__main__":
    main()
