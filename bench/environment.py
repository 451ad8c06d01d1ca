"""Measure steps per CPU second of the environments, and of a simple way to make observations.

Environments make full observations, with all facts each turn; partial ones; and full ones that tell only
changes or only the outcome of the action.

Every gold plan that succeeds is played as commands, episode after episode, resets included. Then the same
states are observed in the simple way: it walks all facts of a state and tells the facts that concern the
task. It tells stored facts alone. BEHAVIOR states goals with derived facts, so there the simple way does less
than the environment.

    python -m bench environment [--seconds N]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple, cast, get_args

from bench.record import add_write_option, write_figures
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.protocol import Ability
from eai.abilities.reports import action_text, fact_text
from eai.agents.gym import TextEnvironment, make
from eai.agents.rules import Observe
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import open_suite
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan

SECONDS = 5.0


class Plan(NamedTuple):
    """A gold plan that succeeds, as ground actions and as commands."""

    task: Task
    domain: Domain
    actions: Sequence[Action]
    commands: Sequence[str]


def list_gold_plans(name: str) -> list[Plan]:
    suite, found = open_suite(name, Ability.ACTION_SEQUENCING), []
    book = open_gold_answers(suite.benchmark, Ability.ACTION_SEQUENCING)
    for task_id in suite.task_ids:
        scorer, text = cast("ActionSequencingScorer", suite.scorer(task_id)), book[task_id].text
        written = scorer.notation.read(text)
        actions = scorer.resolve_names(written) if isinstance(written, WrittenPlan) else None
        if isinstance(actions, tuple) and getattr(scorer.score(text), "success", False):
            commands = [action_text(action, scorer.task.scene) for action in actions]
            found.append(Plan(scorer.task, scorer.domain, actions, commands))
    return found


def play(environment: TextEnvironment, plans: Sequence[Plan]) -> Iterator[int]:
    """Play plans, and yield the number of steps of each episode."""
    for plan in plans:
        environment.reset(options={"task_id": plan.task.id})
        steps = 0
        for command in plan.commands:
            steps += 1
            if environment.step(command)[2]:
                break
        yield steps


def observe_plainly(plans: Sequence[Plan]) -> Iterator[int]:
    """Observe the states of plans by walking all facts, and yield the number of steps of each plan."""
    for plan in plans:
        scene, told = plan.task.scene, {*plan.task.relevant, plan.task.scene.agent}
        states = execute_plan(plan.domain, plan.task.initial, plan.actions).states
        for state in states:
            "\n".join([fact_text(fact, scene) for fact in state.facts() if told.issuperset(fact.arguments)])
        yield len(states) - 1


def measure_steps_per_second(games: Callable[[], Iterator[int]], seconds: float) -> float:
    """Return the steps per CPU second, over as many whole episodes as fit into the time."""
    steps, start = 0, time.process_time()
    while True:
        for played in games():
            steps += played
            spent = time.process_time() - start
            if spent > seconds:
                return steps / spent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="CPU seconds for each number")
    add_write_option(parser)
    arguments = parser.parse_args()
    seconds, rates = arguments.seconds, dict[tuple[str, str], list[float]]()
    ratios: list[float] = []
    for name in PAPER_BENCHMARKS:
        plans = list_gold_plans(name)
        plain = measure_steps_per_second(partial(observe_plainly, plans), seconds)
        print(f"{name}: {len(plans)} plans, {plain:,.0f} steps/s the plain way")
        told = [(observe, "facts") for observe in get_args(Observe)]
        for observe, feedback in [*told, ("full", "changes"), ("full", "outcome")]:
            environment = make(name, observe=observe, max_steps=None, feedback=feedback)
            for _ in play(environment, plans):  # the tasks are built
                pass
            rate = measure_steps_per_second(partial(play, environment, plans), seconds)
            rates.setdefault((name, feedback), []).append(rate)
            ratios += [rate / plain] if (name, feedback) == (PAPER_BENCHMARKS[0], "facts") else []
            times = f"{rate / plain:5.1f} times the plain way"
            print(f"  {observe:8} {feedback:8} {rate:9,.0f} steps/s, {times}")
    if arguments.write:
        with_text = [rate for name in PAPER_BENCHMARKS for rate in rates[name, "facts"]]
        outcomes = [max(rates[name, "outcome"]) for name in PAPER_BENCHMARKS]
        write_figures(
            "environment",
            {
                "Steps per CPU second with the text of observations, both households": _format_range(
                    with_text
                ),
                "Times as fast as the plain way, VirtualHome": _format_range(ratios),
                "Steps with the outcome as text: VirtualHome, BEHAVIOR": ", ".join(
                    f"{rate:,.0f}" for rate in outcomes
                ),
            },
        )


def _format_range(values: Sequence[float]) -> str:
    return f"{min(values):,.0f} to {max(values):,.0f}"
