"""A small kitchen for tests of bodies, with BEHAVIOR's predicates."""

from __future__ import annotations

from collections.abc import Sequence

from eai.benchmarks.behavior.predicates import VOCABULARY
from eai.tasks.task import Task
from eai.world.state import Scene, State

KINDS = {
    "floor_kitchen": "floor.n.01",
    "countertop_1": "countertop.n.01",
    "fridge_2": "electric_refrigerator.n.01",
    "breakfast_table_3": "table.n.02",
    "basket_4": "basket.n.01",
    "apple_5": "apple.n.01",
    "plate_6": "plate.n.04",
    "milk_7": "milk.n.01",
    "hardback_8": "book.n.02",
    "vacuum_9": "vacuum.n.04",
    "apple_5_part_0": "half_apple",
    "apple_5_part_1": "half_apple",
}
SCENE = Scene(VOCABULARY, KINDS)
FACTS = (
    "floor(floor_kitchen)",
    "stands_on(countertop_1, floor_kitchen)",
    "stands_on(fridge_2, floor_kitchen)",
    "stands_on(breakfast_table_3, floor_kitchen)",
    "stands_on(vacuum_9, floor_kitchen)",
    "openable(fridge_2)",
    "lies_on(basket_4, breakfast_table_3)",
    "lies_in(apple_5, basket_4)",
    "lies_on(plate_6, countertop_1)",
    "lies_in(milk_7, fridge_2)",
    "stands_under(hardback_8, breakfast_table_3)",
    "stands_by(vacuum_9, breakfast_table_3)",
    "part_of(apple_5_part_0, apple_5)",
    "part_of(apple_5_part_1, apple_5)",
)


def kitchen(added: Sequence[str] = (), without: Sequence[str] = ()) -> State:
    """The kitchen with some facts more, and some less."""
    return SCENE.state([*(fact for fact in FACTS if fact not in without), *added])


def task_of(state: State) -> Task:
    """A task that begins in a state."""
    return Task("kitchen", "kitchen", "", state, (), tuple(range(len(state.scene.objects))))
