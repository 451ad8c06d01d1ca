"""Compare random plays through gymnasium, Inspect's tools, an MCP server, and as a plan.

    python -m bench random_plays [SUITE ...] [--plays 1000] [--inspect 200] [--mcp 200]

Each play is a sequence of commands of a null agent. A tenth of the commands only look, cannot be read, or
name an object that does not exist. All plays go through gymnasium; the first ones also go through the tools
of Inspect's agents and through an MCP server. Each play is scored as an episode, and its actions as a plan.
Without a fault, both must reach the same goals. With a fault, both must name the same first step and kind.
Equal arguments give equal plays. The exit status is 1 if anything differs.
"""

from __future__ import annotations

import argparse
import asyncio
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from inspect_ai.model import ChatMessageUser, ModelName
from inspect_ai.solver import TaskState
from mcp import Client

from bench.record import add_write_option, write_figures
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.agents.agents import NULLS
from eai.agents.command import DONE, LOOK
from eai.agents.episode_server import find_journal_path, open_episode_server
from eai.agents.gym import TextEnvironment, make
from eai.agents.journal import read_journal, read_key_that_seals_journals
from eai.agents.play import EpisodeFactory, RecordedGame
from eai.agents.rules import STANDARD as RULES
from eai.agents.server import make_mcp_server
from eai.agents.setting import ACTING, AGENT_SETTING_FIELD, STANDARD
from eai.agents.verdict import EpisodeVerdict
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import Suite, open_suite
from eai.run.acting import offer_task_tools, read_episode_text
from eai.world.action import Action

ODD = ("OPEN(moon)", "FLY()", "()", "[]()", "I open it.()", "OPEN(()", "OPEN(a, b, c, d)", LOOK)
"""Commands that are no actions, in the form that a tool call makes."""

Told = Sequence[str]
"""The observations of a play, one for each command."""


@dataclass
class Check:
    """Numbers of comparisons, and the first differences of each kind."""

    counts: Counter[str] = field(default_factory=Counter)
    differences: list[str] = field(default_factory=list)

    def same(self, kind: str, place: object, one: object, other: object) -> None:
        self.counts[kind] += 1
        if one != other:
            self.differences.append(f"{kind}, {place}: {one!r} is not {other!r}")


def drawn(arena: EpisodeFactory, suite: Suite, number: int) -> tuple[RecordedGame, Told]:
    """Draw a random play, and return it with its observations."""
    rng = random.Random(f"play {number}")
    tasks = [task for task in suite.tasks.values() if task.unplannable_reason is None]
    play = arena.begin_episode(rng.choice(tasks))
    name = rng.choice(["random", "blind"] if number % 10 else ["novel"])
    agent, told, most = NULLS[name](play, number), list[str](), rng.randrange(1, 60)
    while not play.is_over and len(told) < most:
        odd = rng.random() < 0.1
        told.append(play.play_command(rng.choice(ODD) if odd else agent()))
    return play, told


def through_gymnasium(environment: TextEnvironment, play: RecordedGame) -> tuple[list[str], list[str | None]]:
    """Play the commands in gymnasium, and return the observations and the faults."""
    environment.reset(options={"task_id": play.task.id})
    turns = [environment.step(turn.said) for turn in play.turns]
    return [turn[0] for turn in turns], [turn[4]["fault"] for turn in turns]


def as_calls(play: RecordedGame) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the commands as tool calls."""
    calls: list[tuple[str, Mapping[str, Any]]] = []
    for turn in play.turns:
        name, _, objects = turn.said.partition("(")
        if turn.said in (LOOK, DONE):
            calls.append(("look" if turn.said == LOOK else "done", {}))
        else:
            given = objects.removesuffix(")").split(", ") if objects.removesuffix(")") else []
            calls.append(("act", {"action": name, "objects": given}))
    return calls


async def through_inspect(domain: str, play: RecordedGame) -> tuple[Told, str]:
    """Make the tool calls in Inspect, and return the observations and the stored episode."""
    about = {"domain": domain, "ability": ACTING.value, AGENT_SETTING_FIELD: STANDARD.model_dump_json()}
    messages: list[Any] = [ChatMessageUser(content="")]
    task_id = play.task.id
    state = TaskState(ModelName("mockllm/model"), task_id, 1, "", messages, metadata=about)
    await offer_task_tools()(state, cast("Any", None))
    tools = dict(zip(("act", "look", "done"), state.tools, strict=True))
    told = [
        str(await cast("Callable[..., Awaitable[str]]", tools[n])(**given)) for n, given in as_calls(play)
    ]
    return told, read_episode_text(state)


async def through_mcp(client: Client, play: RecordedGame) -> Told:
    """Make the tool calls on an MCP server, and return the observations."""
    results = [await client.call_tool(name, dict(given)) for name, given in as_calls(play)]
    return [cast("Any", result.content[0]).text for result in results]


def as_plan(play: RecordedGame, faults: Sequence[str | None]) -> tuple[list[Action], list[int]] | None:
    """Return the actions of a play with their turns, or None if a command was no action."""
    actions, turns, late = [], [], play.ended == "steps"
    everything = range(len(play.task.scene.objects))
    for number, turn in enumerate(play.turns[: len(play.turns) - late]):
        meant, _ = play.setup.commands.read_command_and_repairs(turn.said, everything, may_end_episode=True)
        if turn.said in (LOOK, DONE):
            continue
        if not isinstance(meant, Action) or faults[number] == "hallucination":
            return None
        actions.append(meant)
        turns.append(number)
    return actions, turns


def compare_plan(
    check: Check, place: object, plans: Suite, play: RecordedGame, verdict: EpisodeVerdict
) -> None:
    """Compare an episode with the plan of its actions."""
    faults = [None if turn.fault is None else turn.fault.value for turn in verdict.turns]
    found = as_plan(play, faults)
    if found is None or not found[0]:
        return
    actions, turns = found
    notation, task = plans.benchmark.notation.plans, play.task
    text = notation.join(notation.write(actions, task.scene))
    plan = cast("PlanVerdict", plans.score(task.id, text))
    ending = [i for i, n in enumerate(turns) if faults[n] not in (None, "additional_step")]
    first = (ending[0], faults[turns[ending[0]]]) if ending else None
    error = None if plan.error is None else (plan.error.step, plan.error.kind.value)
    check.same("first fault as in a plan", place, error, first)
    if not ending:
        check.same("goals as of a plan", place, plan.goals_satisfied, verdict.goals_satisfied)
        check.same("success as of a plan", place, plan.success, verdict.reached)


def played(check: Check, name: str, plays: int, by_inspect: int, by_mcp: int) -> None:
    """Play one suite through all interfaces."""
    suite, plans = open_suite(name, ACTING), open_suite(name, Ability.ACTION_SEQUENCING)
    arena, environment = EpisodeFactory(suite.benchmark), make(name, rules=RULES)
    for number in range(max(plays, by_inspect, by_mcp)):
        play, told = drawn(arena, suite, number)
        place, text = f"{name} play {number}", play.write_as_json_text("stopped")
        if number < plays:
            observed, faults = through_gymnasium(environment, play)
            check.same("gymnasium: observations", place, observed, told)
            verdict = cast("EpisodeVerdict", suite.score(play.task.id, text))
            check.same("scoring: replays", place, verdict.excluded, None)
            scored = [None if turn.fault is None else turn.fault.value for turn in verdict.turns]
            check.same("scoring and gymnasium: faults", place, scored, faults)
            check.same("scoring: end", place, verdict.ended, play.ended or "stopped")
            check.same("scoring: won", place, verdict.success, play.won)
            compare_plan(check, place, plans, play, verdict)
        if number < by_inspect:
            by_tools, stored = asyncio.run(through_inspect(name, play))
            check.same("Inspect: observations", place, by_tools, told)
            again = suite.score(play.task.id, stored)
            check.same("Inspect: verdict", place, again, suite.score(play.task.id, text))
        if number < by_mcp:
            compare_mcp(check, place, suite, play, told)


def compare_mcp(check: Check, place: object, suite: Suite, play: RecordedGame, told: Told) -> None:
    """Compare a play with itself over MCP, whose first look states the task."""
    if play.turns[0].said == LOOK:
        return
    task_id = play.task.id
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").exists() else None) as folder:  # noqa: S108
        with open_episode_server(Path(folder), suite, [(task_id, 1)]) as worlds:

            async def run() -> Told:
                async with Client(make_mcp_server(worlds, suite.benchmark.domain)) as client:
                    return await through_mcp(client, play)

            check.same("MCP: observations", place, asyncio.run(run()), told)
            path = find_journal_path(Path(folder), (task_id, 1))
        text = read_journal(path, read_key_that_seals_journals(Path(folder)), must_be_ended=False)
        verdict = cast("EpisodeVerdict", suite.score(task_id, text))
        plain = cast("EpisodeVerdict", suite.score(task_id, play.write_as_json_text("stopped")))
        check.same("MCP: verdict", place, (verdict.turns, verdict.ended), (plain.turns, plain.ended))
        check.same("MCP: won", place, verdict.success, plain.success)


def main() -> None:
    """Play the suites, and print the numbers of comparisons and the differences."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("suites", nargs="*", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--plays", type=int, default=1000, help="of each suite")
    parser.add_argument(
        "--inspect", type=int, default=200, help="how many of them go through Inspect's tools"
    )
    parser.add_argument("--mcp", type=int, default=200, help="how many of them go over MCP")
    add_write_option(parser)
    arguments = parser.parse_args()
    check, start = Check(), time.process_time()
    for name in arguments.suites:
        played(check, name, arguments.plays, arguments.inspect, arguments.mcp)
    for kind, number in sorted(check.counts.items()):
        print(f"{number:8,} {kind}")
    seconds = time.process_time() - start
    print(f"{len(check.differences):,} differences; {seconds:.0f} CPU s")
    if arguments.write:
        plays = arguments.plays * len(arguments.suites)
        write_figures(
            "random_plays",
            {
                "Plays through gymnasium, scored as episodes": plays,
                "Differences": len(check.differences),
                "CPU seconds": round(seconds),
            },
        )
    print("\n".join([each[:500] for each in check.differences[:10]]))
    sys.exit(bool(check.differences))
