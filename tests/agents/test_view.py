from __future__ import annotations

import random
import re
from typing import get_args

import pytest

from eai.abilities.protocol import Ability
from eai.agents.game import Game
from eai.agents.observation import Observer
from eai.agents.reference import make_setup
from eai.agents.rules import STANDARD, Observe
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.short_lists import expand_shortened_lists
from eai.tasks.source import Source
from eai.world.episode import Episode
from eai.world.state import State, compare_states

TASKS = {
    "virtualhome": ("27_2", "1003_2", "499_1"),
    "behavior": (
        "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46",
        "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37",
    ),
}


@pytest.mark.parametrize("observe", get_args(Observe))
@pytest.mark.parametrize(("name", "task_id"), [(n, t) for n, ids in TASKS.items() for t in ids])
def test_incremental_observations_equal_new_ones(
    name: str, task_id: str, observe: Observe, data_store: DataPackStore
) -> None:
    benchmark = find_benchmark(name)
    task = benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source(data_store))[task_id]
    wording, rng = benchmark.observation_wording(), random.Random(0)
    observer, episode = Observer(task, wording, observe), Episode(benchmark.domain, task.initial)
    observation = observer.first
    stored = {
        each.predicate
        for each in wording.fact_listers_of_goal_predicates
        if each.sources == (each.predicate,)
    }
    for _ in range(40):
        operator = rng.choice(benchmark.domain.operators)
        possible = list(
            generate_applicable_actions_of_operator(benchmark.domain, operator, episode.state, task.relevant)
        )
        if not possible:
            continue
        outcome = episode.act(rng.choice(possible))
        assert isinstance(outcome, State)
        difference = compare_states(observation.state, outcome)
        before, observation = observation, observer.observe(observation, outcome, difference)
        facts = [
            fact
            for each in wording.fact_listers_of_goal_predicates
            for fact in each.list_facts(outcome, observation.visible)
        ]
        lines = expand_shortened_lists(observation.facts_text).splitlines()
        assert sorted(lines) == sorted([wording.write_fact(task, fact) for fact in facts])
        changes = observer.find_visible_changes(before, observation, difference)
        told = [f"{sign} {observer.render_fact(fact)}" for sign, fact in changes]
        expected = {
            f"{sign} {wording.write_fact(task, fact)}"
            for sign, facts, seen in (
                ("+", difference.added, observation.visible),
                ("-", difference.removed, before.visible),
            )
            for fact in facts
            if fact.predicate in stored and {*seen}.issuperset(fact.arguments)
            if len({*fact.arguments}) == len(fact.arguments)
        }
        assert {line for line in told if line[2:].partition("(")[0] in stored} == expected


@pytest.mark.parametrize(("name", "task_id"), [(n, t) for n, ids in TASKS.items() for t in ids])
def test_visible_facts_follow_from_the_first_observation_and_changes(
    name: str, task_id: str, data_store: DataPackStore
) -> None:
    benchmark = find_benchmark(name)
    task = benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source(data_store))[task_id]
    game = Game(make_setup(task, benchmark, STANDARD.model_copy(update={"budget": None})))
    rng = random.Random(1)
    believed = {*expand_shortened_lists(game.write_first_observation()).partition("Now:\n")[2].splitlines()}
    for turn in range(60):
        walks = [each for each in game.find_possible_actions() if each.operator == "WALK"]
        action = rng.choice(walks if walks and turn % 4 == 0 else [*game.find_possible_actions()])
        told = expand_shortened_lists(game.act(game.setup.commands.write_command(action)).observation)
        for line in told.splitlines():
            if line[:2] == "- ":
                believed.discard(line[2:])
            elif line.endswith(")"):
                believed.add(line.removeprefix("+ "))
        holds = {*expand_shortened_lists(game.memory.observation.facts_text).splitlines()}
        seen = {
            *expand_shortened_lists(game.setup.observer.render_names(game.memory.observation.visible)).split(
                ", "
            )
        }
        assert holds <= believed
        assert [each for each in believed - holds if {*re.findall(r"[\w.]+", each)[1:]} <= seen] == []
