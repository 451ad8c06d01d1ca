from __future__ import annotations

from collections import Counter

from eai.abilities.transition_modeling.task import Category
from eai.data.store import Store
from eai.households.gold_operators import (
    TransitionTasks,
    open_behavior,
    open_virtualhome,
)


def sizes(tasks: TransitionTasks) -> dict[str, int]:
    found = Counter(category.value for task in tasks.values() for category in task.categories)
    return dict(found)


def test_virtualhome_is_categorised_as_the_data_set_has_it(data_store: Store) -> None:
    assert sizes(open_virtualhome(data_store)) == {
        "object_states": 178,
        "object_affordance": 167,
        "object_orientation": 28,
        "spatial_relations": 145,
        "non_spatial_relations": 74,
    }


def test_behavior_is_categorised_as_the_data_set_has_it(data_store: Store) -> None:
    assert sizes(open_behavior(data_store)) == {
        "object_states": 45,
        "spatial_relations": 94,
        "non_spatial_relations": 61,
    }


def test_tools_are_no_category_of_tasks(data_store: Store) -> None:
    tasks = open_virtualhome(data_store)
    assert Category.OBJECT_TOOLS in tasks.domain.categories.values()
    assert all(Category.OBJECT_TOOLS not in task.categories for task in tasks.values())
