"""Agents without a model, and the references that they make, in the standard setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest

import eai.world as w
from agents.switches import SWITCHES
from eai import Benchmark, make_task, use_tasks
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS, NULLS
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.reference import make_setup
from eai.agents.rules import STANDARD, GameRules
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.logic.formula import Always, And, Atom, Constant, Not, Occurs
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.action import Action

TASKS: Mapping[str, Task] = SWITCHES.tasks_for(Ability.ACTION_SEQUENCING, Source())
PLAN = (("PRESS", "lamp"), ("GO", "shed"), ("PRESS", "torch"))
"""A plan for the task ``both`` by an agent that sees everything."""

EVERY = {"virtualhome": 24, "behavior": 14}
"""Step between the tasks of a household that are played."""


def played(agent: str, setup: GameSetup, seed: int = 0) -> tuple[Game, list[str]]:
    game = Game(setup)
    command, commands = AGENTS[agent](game, seed), list[str]()
    while not game.is_over:
        commands.append(command())
        game.act(commands[-1])
    return game, commands


def setups(name: str, store: DataPackStore, rules: GameRules = STANDARD) -> list[GameSetup]:
    benchmark = find_benchmark(name)
    tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source(store))
    ids = [task_id for task_id in tasks if tasks[task_id].unplannable_reason is None]
    return [make_setup(tasks[task_id], benchmark, rules) for task_id in ids[:: EVERY[name]]]


@pytest.mark.parametrize("task_id", ["both", "greet", "half", "done"])
def test_the_explorer_finds_hidden_objects_and_declares_the_end(task_id: str) -> None:
    game, commands = played("explorer", make_setup(TASKS[task_id], SWITCHES, STANDARD))
    assert (game.won, game.ended, commands[-1]) == (True, "done", DONE)
    if task_id == "both":
        assert commands == ["GO(shed)", "OPEN(box)", "PRESS(torch)", "GO(hall)", "PRESS(lamp)", DONE]


def test_the_explorer_revisits_landmarks_after_opening_containers() -> None:
    """The torch, in the box in the shed, is visible from the hall; generated scenes have such objects."""
    scene, both = TASKS["both"].scene, TASKS["both"]
    facts = [
        fact for fact in both.initial.facts() if fact != ("at", (scene.index["torch"], scene.index["shed"]))
    ]
    start = scene.state([*facts, ("at", (scene.index["torch"], scene.index["hall"]))])
    game, commands = played("explorer", make_setup(replace(both, initial=start), SWITCHES, STANDARD))
    assert game.won
    assert commands == ["GO(shed)", "OPEN(box)", "GO(hall)", "PRESS(lamp)", "PRESS(torch)", DONE]


def test_the_explorer_makes_objects_that_do_not_exist_yet() -> None:
    x, y = w.Variable("x"), w.Variable("y")
    whole, mill = w.Predicate("whole", 1), w.Predicate("mill", 1, static=True)
    turn = w.Operator(
        "TURN",
        (x,),
        (w.affordance(mill(x), "{x} is no mill"),),
        (w.ForEach(y, ~mill(y), (w.Add(whole(y)),)),),
    )
    domain = w.Domain("mills", w.Vocabulary((whole, mill)), (turn,), visible=whole(x))
    scene = w.Scene(domain.vocabulary, [w.WorldObject("mill", "mill"), w.WorldObject("flour", "flour")])
    start = scene.state([("mill", (0,)), ("whole", (0,))])
    task = make_task("grind", "Make flour.", start, whole(w.Constant("flour")))
    game, commands = played(
        "explorer", make_setup(task, Benchmark("mills", domain, use_tasks(task)), STANDARD)
    )
    assert (game.won, commands) == (True, ["TURN(mill)", DONE])


def test_a_reference_can_be_played_and_determines_the_budget() -> None:
    setup = make_setup(TASKS["both"], SWITCHES, STANDARD)
    shortest, commands = setup.reference
    assert shortest == 3, "the torch can be pressed in its box, which who does not know of it cannot do"
    assert commands is not None
    assert setup.action_limit == 2 * 3 + 8 == setup.reference.compute_action_limit(2)
    assert setup.reference.compute_action_limit(0) == 8
    assert setup.reference._replace(commands=("WAVE()",) * 30).compute_action_limit(2) == 30
    assert make_setup(TASKS["both"], SWITCHES, STANDARD.model_copy(update={"max_steps": 3})).action_limit == 3
    assert make_setup(TASKS["both"], SWITCHES, GameRules()).action_limit == 100


def test_a_reference_follows_the_plan_if_exploring_first_breaks_a_rule() -> None:
    """An explorer enters the dark shed, which breaks a rule. The plan ignores that the torch is hidden."""
    both = TASKS["both"]
    dark = Not(Atom("lit", (Constant("lamp"),)))
    rule = Always(Not(And((Atom("at", (Constant("robot"), Constant("shed"))), dark))))
    plan = tuple([Action(name, (both.scene.index[thing],)) for name, thing in PLAN])
    goals = (*both.goals, *make_task("rule", "", both.initial, rule).goals)
    task = replace(both, goals=goals, script=plan)
    setup = make_setup(task, SWITCHES, STANDARD)
    assert not any(played(agent, setup)[0].won for agent in ("gold", "explorer"))
    assert setup.reference.commands == ("PRESS(lamp)", "GO(shed)", "OPEN(box)", "PRESS(torch)")


def test_the_greedy_agent_sees_which_action_goals_it_has_met() -> None:
    both = TASKS["both"]
    lit = Atom("lit", (Constant("lamp"),))
    waved = make_task("wave", "Turn the lamp on and wave.", both.initial, Occurs("WAVE"), lit)
    game, commands = played("greedy", make_setup(waved, SWITCHES, STANDARD))
    assert (game.won, sorted(commands)) == (True, [DONE, "PRESS(lamp)", "WAVE()"])


@pytest.mark.parametrize("agent", NULLS)
def test_null_agents_act_by_their_seed(agent: str) -> None:
    setup = make_setup(TASKS["both"], SWITCHES, STANDARD)
    games = [played(agent, setup, seed)[1] for seed in (0, 0, 1, 2, 3)]
    assert games[0] == games[1]
    assert len({tuple(commands) for commands in games}) > 1


def test_the_novel_agent_prefers_new_states_and_the_blind_agent_takes_any_action() -> None:
    setup = make_setup(TASKS["both"], SWITCHES, STANDARD)
    for seed in range(5):
        for agent in ("random", "novel"):
            game, commands = played(agent, setup, seed)
            replay = Game(setup)
            assert all(
                replay.act(command).info["fault"] is None
                for command in commands[: len(game.executed_operators)]
            )
    assert any(
        len(game.executed_operators) < len(commands) - 1 for game, commands in [played("blind", setup)]
    )


@pytest.mark.parametrize("name", EVERY)
def test_planning_agents_win_and_null_agents_lose(name: str, data_store: DataPackStore) -> None:
    tasks = setups(name, data_store)
    assert [setup.task.id for setup in tasks if not played("oracle", setup)[0].won] == []
    assert sum(played("explorer", setup)[0].won for setup in tasks) >= 0.95 * len(tasks)
    assert sum(played("blind", setup)[0].won for setup in tasks) == 0
    assert sum(played("random", setup)[0].won for setup in tasks[::3]) == 0
    assert played("greedy", min(tasks, key=lambda setup: setup.reference.shortest or 0))[0].won
