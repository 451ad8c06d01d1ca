"""Play tasks with agents that need no model, and print how many episodes each agent wins.

    python -m bench acting [SUITE ...] [--sample 40] [--seeds 1] [--agents random ...] [--view task]

A suite is a benchmark or a task file; by default both households. `--sample` tasks of each suite are played,
evenly spaced (0: all). Tasks without a reference plan in this view are left out and counted.

A budget is a multiple of the length of the shortest known plan, or the budget of the setting. The table has
the share of episodes won within each budget, counted in two ways. The first counts an episode as won if the
agent says `DONE` when all goals hold, as the setting demands. The second uses the last state, also for agents
that never say `DONE` in time. Null agents draw `DONE` with the same chance as any other command. For the
second number they continue to act after `DONE`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, get_args

from bench.record import add_write_option, write_rows
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS, NULLS, Agent
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.reference import make_setup
from eai.agents.rules import STANDARD, GameRules, View
from eai.benchmarks.registry import PAPER_BENCHMARKS, find_benchmark
from eai.tasks.source import Source

TIMES = (1, 2, 4)


class EpisodeProgress(NamedTuple):
    """Whether all goals held after each number of actions, and the number of actions before `DONE`."""

    held: Sequence[bool]
    done: int | None

    def wins_by_done(self, budget: int) -> bool:
        return self.done is not None and self.done <= budget and self.held[self.done]

    def wins_by_last_state(self, budget: int) -> bool:
        return self.held[min(budget, len(self.held) - 1)]


def play_for_progress(
    setup: GameSetup, make: Callable[[Game, int], Agent], seed: int, *, acts_on: bool
) -> EpisodeProgress:
    """Play an episode with an agent for the largest budget of actions."""
    game = Game(setup.copy_setup_without_failures_and_step_limit())
    agent, held, done = make(game, seed), [all(game.reached)], None
    most = max(TIMES[-1] * (setup.reference.shortest or 0), setup.action_limit or 0)
    while True:
        command, tried = agent(), len(held) - 1
        if command == DONE and done is None:
            done = tried
        if tried == most or (command == DONE and not acts_on):
            return EpisodeProgress(held, done)
        if command != DONE:
            game.act(command)
        held.append(all(game.reached))


def sample_setups(name: str, rules: GameRules, sample: int) -> tuple[list[GameSetup], int]:
    """Return the sampled tasks that have a reference plan, and the number of tasks without one."""
    benchmark = find_benchmark(name)
    tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source())
    ids = [task_id for task_id in tasks if tasks[task_id].unplannable_reason is None]
    chosen = ids[:: max(1, len(ids) // sample)] if sample else ids
    playable = []
    for number, task_id in enumerate(chosen, 1):
        print(f"\r{name}: reference {number} of {len(chosen)}, {task_id:<60.60}", end="", file=sys.stderr)
        setup = make_setup(tasks[task_id], benchmark, rules)
        if setup.reference.commands is not None:
            playable.append(setup)
    print(file=sys.stderr)
    return playable, len(chosen) - len(playable)


def measure_win_shares(courses: Sequence[tuple[EpisodeProgress, int]]) -> str:
    """Return the shares of episodes won within each budget, by `DONE` and by the last state."""
    done = sum(course.wins_by_done(budget) for course, budget in courses)
    state = sum(course.wins_by_last_state(budget) for course, budget in courses)
    return f"{100 * done / len(courses):.1f} / {100 * state / len(courses):.1f}"


def main() -> None:
    """Play all agents on all suites, and print a table of the shares they win."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("suites", nargs="*", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--sample", type=int, default=40, help="tasks of each suite, about; 0: all")
    parser.add_argument("--seeds", type=int, default=1, help="games of each null in each task")
    parser.add_argument("--agents", nargs="+", choices=AGENTS, default=list(AGENTS))
    parser.add_argument("--view", choices=get_args(View), default="scene")
    add_write_option(parser)
    arguments, rows = parser.parse_args(), []
    rules = STANDARD.model_copy(update={"view": arguments.view})
    print("| suite | agent | games |", *[f"{times} L |" for times in TIMES], "budget | CPU ms a game |")
    print("|---|---|--:|", *["--:|" for _ in TIMES], "--:|--:|")
    for name in arguments.suites:
        playable, left_out = sample_setups(name, rules, arguments.sample)
        lengths = sorted([setup.reference.shortest or 0 for setup in playable])
        for called in arguments.agents:
            seeds, start = range(arguments.seeds if called in NULLS else 1), time.process_time()
            games = [
                (setup, play_for_progress(setup, AGENTS[called], seed, acts_on=called in NULLS))
                for setup in playable
                for seed in seeds
            ]
            spent = 1000 * (time.process_time() - start) / len(games)
            shown = [
                measure_win_shares([(game, times * (setup.reference.shortest or 0)) for setup, game in games])
                for times in TIMES
            ]
            shown.append(measure_win_shares([(game, setup.action_limit or 0) for setup, game in games]))
            rows.append([name, called, len(games), *shown, round(spent)])
            print(f"| {' | '.join(map(str, rows[-1]))} |", flush=True)
        middle = lengths[len(lengths) // 2]
        print(f"{name}: L {lengths[0]} to {lengths[-1]}, median {middle}; left out: {left_out}", flush=True)
    if arguments.write:
        write_rows("acting", rows, keys=2)
