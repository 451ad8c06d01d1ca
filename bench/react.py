"""Let Inspect's agent `react` play with a scripted model, and measure time and tokens.

    python -m bench react [--domain virtualhome] [--tasks 10]

The model is the server of mcp_agent.py, which says the commands of the reference plan. The program prints the
episodes, the number won, and the CPU seconds per task, start-up included. Then it plays the same tasks at
random for 30 turns without Inspect. It prints the characters that a model has read and written at the end, as
tokens of 3.5 characters, and the CPU milliseconds per episode. The time to prepare a task is listed
separately.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

from bench.mcp_agent import serve_model
from bench.record import add_write_option, write_rows
from bench.result import Figure
from eai.agents.agents import random_agent
from eai.agents.command import DONE
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING, AgentSetting
from eai.benchmarks.suite import Suite, open_suite

TURNS = 30
CHARACTERS = 3.5
"""Approximate number of characters of a token."""

CALL = 120
"""Approximate characters of a tool call and its reply besides the command and the observation."""


def play_with_inspect(suite: Suite, task_ids: Sequence[str]) -> list[Figure]:
    """Play by the command in the docs. Print and return the tasks won and the CPU seconds per task."""
    arena = EpisodeFactory(suite.benchmark)
    tasks = [suite.tasks[task_id] for task_id in task_ids]
    gold = {arena.make_prompt(task).user: arena.make_setup(task).reference.commands or () for task in tasks}
    with tempfile.TemporaryDirectory() as folder, serve_model(gold) as url:
        command = [sys.executable, "-m", "eai", "run", "--ability", "acting", "--domain", suite.domain]
        command += ["--tasks", ",".join(task_ids), "--model", "openai-api/local/scripted"]
        command += ["--model-base-url", url, "-M", "api_key=none", "--out", folder, "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        success = json.loads(done.stdout)[0]["metrics"]["success"]
        spent = (used.ru_utime + used.ru_stime) / len(tasks)
        won = f"{success['numerator']} of {success['denominator']}"
        print(f"{won} won, {spent:.2f} CPU s a task")
        return [won, round(spent, 2)]


def play_at_random(suite: Suite, task_ids: Sequence[str]) -> list[Figure]:
    """Play without Inspect. Print and return the tokens of contexts and the CPU ms per episode."""
    arena = EpisodeFactory(suite.benchmark, AgentSetting(steps=TURNS, budget=1_000))
    contexts, ready, played = [], 0.0, 0.0
    for task_id in task_ids:
        start = time.process_time()
        task = suite.tasks[task_id]
        read = len(arena.make_prompt(task).user)
        suite.score(
            task_id, arena.begin_episode(task).write_as_json_text("stopped")
        )  # makes the scorer before time is taken
        ready += time.process_time() - start
        play = arena.begin_episode(task)
        agent = random_agent(play)
        for _ in range(TURNS):
            command = DONE
            while command == DONE:  # without this condition episodes would end before the last turn
                command = agent()
            start = time.process_time()
            told = play.play_command(command)
            played += time.process_time() - start
            read += len(command) + len(told) + CALL
        start = time.process_time()
        suite.score(task_id, play.write_as_json_text("stopped"))
        played += time.process_time() - start
        contexts.append(read / CHARACTERS)
    number = len(task_ids)
    print(f"{TURNS} turns: {sum(contexts) / number:,.0f} tokens of context, at most {max(contexts):,.0f}")
    spent, before = 1000 * played / number, 1000 * ready / number
    print(f"an episode: {spent:.1f} CPU ms played and scored, {before:.0f} to make its task ready")
    return [f"{sum(contexts) / number:,.0f} ({max(contexts):,.0f})", round(spent, 1)]


def main() -> None:
    """Measure episodes with and without Inspect, and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--domain", default="virtualhome")
    parser.add_argument("--tasks", type=int, default=10)
    add_write_option(parser)
    arguments = parser.parse_args()
    suite = open_suite(arguments.domain, ACTING)
    there = [task_id for task_id in suite.task_ids if suite.tasks[task_id].unplannable_reason is None]
    task_ids = there[:: max(1, len(there) // arguments.tasks)][: arguments.tasks]
    row = [arguments.domain, *play_with_inspect(suite, task_ids), *play_at_random(suite, task_ids)]
    if arguments.write:
        write_rows("react", [row])
