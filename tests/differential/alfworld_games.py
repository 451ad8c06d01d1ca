"""Compare random games of ALFWorld on TextWorld's engine and on `eai`.

    python -m bench alfworld_games --python PYTHON [--games 48] [--turns 2100] [--seed 1]

PYTHON is the interpreter of an environment with the packages `alfworld` and `textworld[pddl]`. The exit
status is 1 if the engines differ.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

from bench.record import add_write_option, write_figures
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source

CHILD = Path(__file__).with_name("alfworld_child.py")
STATIC_KINDS = "cancontain"
"""Predicate with hundreds of facts that no action changes; it is not compared each turn."""


def facts(game: Game) -> list[str]:
    """Return all true facts in the notation of `alfworld_child.py`."""
    objects = [each.name.replace("_", " ") for each in game.task.scene.objects]
    return sorted(
        f"{fact.predicate} {' '.join(objects[i] for i in fact.arguments)}"
        for fact in game.state.facts()
        if fact.predicate != STATIC_KINDS
    )


def differences(game: Game, played: Path) -> list[str]:
    """Return the first difference in a game, if any."""
    for number, raw in enumerate(played.read_text().splitlines()):
        line = json.loads(raw)
        possible = sorted(
            {game.setup.commands.write_command(action) for action in game.find_possible_actions()}
        )
        ours = (possible, facts(game), all(game.reached))
        for what, mine, other in zip(
            ("commands", "facts", "won"), ours, (line["commands"], line["facts"], line["won"]), strict=True
        ):
            if mine != other:
                odd = set(mine) ^ set(other) if isinstance(mine, list) else (mine, other)
                return [f"{played.parent.parent.name} turn {number}: {what} differ: {sorted(odd)[:5]}"]
        game.act(line["taken"])
    return []


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", required=True)
    parser.add_argument("--games", type=int, default=48)
    parser.add_argument("--turns", type=int, default=2100)
    parser.add_argument("--seed", type=int, default=1)
    add_write_option(parser)
    chosen = parser.parse_args()
    with TemporaryDirectory() as folder:
        words = (folder, chosen.games, chosen.turns, chosen.seed)
        subprocess.run([chosen.python, "-E", str(CHILD), *map(str, words)], check=True)
        benchmark = find_benchmark(f"alfworld:{folder}")
        tasks = benchmark.tasks(Source())
        rules = GameRules(until="done", max_steps=None, feedback="outcome")
        odd, won, before = list[str](), 0, process_time()
        for played in sorted(Path(folder).rglob("played.jsonl")):
            task = tasks[".".join(played.parent.relative_to(folder).parts)]
            odd += differences(Game(make_setup(task, benchmark, rules)), played)
            won += '"won": true' in played.read_text()
        taken = chosen.games * chosen.turns
        print(f"{taken:,} actions in {chosen.games} games, {won} of them won: {len(odd)} games differ")
        print(f"{process_time() - before:.0f} CPU s on our side")
    for line in odd:
        print(line)
    if chosen.write:
        write_figures(
            "alfworld_games",
            {"Random actions in games on both engines": taken, "Games that differ": len(odd)},
        )
    raise SystemExit(bool(odd))
