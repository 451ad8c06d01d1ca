"""Household actions of published planning operators."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.base.store import DataPackStore
from eai.benchmarks.behavior import counterparts as behavior
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.benchmarks.virtualhome import counterparts as virtualhome
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlannerChoice
from eai.pddl.reader import read_action
from eai.tasks.source import ErrataChoice, Source
from eai.world.action import Action

DOORS = "locking_every_door_0_Merom_1_int_0_2021-10-20_05-53-14"
TABLES = {"virtualhome": virtualhome.COUNTERPARTS, "behavior": behavior.COUNTERPARTS}


def open_operator_suite(
    name: str, store: DataPackStore, errata: ErrataChoice = ErrataChoice.CURRENT
) -> Suite:
    source = Source(store, planner=PlannerChoice.NONE, errata=errata)
    return open_suite(name, Ability.TRANSITION_MODELING, source=source)


def translate_steps(
    name: str, task_id: str, steps: Sequence[str], store: DataPackStore
) -> list[tuple[str, ...]]:
    """Return the actions of steps, each with the names of its objects."""
    scorer = open_operator_suite(name, store).scorer(task_id)
    assert isinstance(scorer, TransitionModelingScorer)
    task = find_benchmark(name).tasks(Source(store))[task_id]
    split = [step.split() for step in steps]
    made = scorer.task.actions_of(task, [PlanStep(word, tuple(words)) for word, *words in split])
    return [_name_objects(action, [obj.name for obj in task.scene.objects]) for action in made]


def _name_objects(action: Action, names: Sequence[str]) -> tuple[str, ...]:
    return (action.operator, *[names[index] for index in action.arguments])


@pytest.mark.parametrize("name", list(TABLES))
@pytest.mark.parametrize("errata", list(ErrataChoice))
def test_each_published_operator_has_an_action_with_the_same_number_of_objects(
    data_store: DataPackStore, name: str, errata: ErrataChoice
) -> None:
    suite = open_operator_suite(name, data_store, errata)
    scorer = suite.scorer(suite.task_ids[0])
    assert isinstance(scorer, TransitionModelingScorer)
    arities = suite.benchmark.domain.operator_arities
    for operator, text in scorer.task.domain.operators.items():
        action, positions = TABLES[name][operator]
        hands = ("",) if action in arities else ("RIGHT_", "LEFT_")
        for hand in hands:
            assert arities[f"{hand}{action}"] == len(positions), operator
        assert max(positions, default=0) < len(read_action(text.write_pddl).parameters), operator


def test_classes_in_virtualhome_problems_mean_the_objects_of_plans(data_store: DataPackStore) -> None:
    steps = ["walk_towards character freezer", "put_inside character food_food freezer", "standup character"]
    assert translate_steps("virtualhome", "703_2", steps, data_store) == [
        ("WALK", "freezer.289"),
        ("PUTIN", "food_food.1000", "freezer.289"),
        ("STANDUP",),
    ]


def test_a_hand_places_the_object_that_it_grasped(data_store: DataPackStore) -> None:
    one, two = "door_n_01_1", "door_n_01_2"
    steps = [
        f"{step} agent_n_01_1"
        for step in (
            f"place_inside {one} {two}",
            f"grasp {one}",
            f"grasp {two}",
            f"place_ontop {two} {one}",
            f"grasp {two}",
            f"release {one}",
            f"place_nextto_ontop {two} {one} {one}",
        )
    ]
    assert translate_steps("behavior", DOORS, steps, data_store) == [
        ("RIGHT_PLACE_INSIDE", "door_89"),
        ("RIGHT_GRASP", "door_85"),
        ("LEFT_GRASP", "door_89"),
        ("LEFT_PLACE_ONTOP", "door_85"),
        ("LEFT_GRASP", "door_89"),
        ("RIGHT_RELEASE", "door_85"),
        ("LEFT_PLACE_NEXTTO_ONTOP", "door_85", "door_85"),
    ]


@pytest.mark.parametrize("step", ["navigate_to agent_n_01_1 agent_n_01_1", "fly door_n_01_1 agent_n_01_1"])
def test_actions_end_before_the_first_step_without_an_action(data_store: DataPackStore, step: str) -> None:
    door = "close door_n_01_1 agent_n_01_1"
    assert translate_steps("behavior", DOORS, [door, step, door], data_store) == [("CLOSE", "door_85")]
