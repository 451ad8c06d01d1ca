"""The real data of BEHAVIOR-1K, and a kitchen of its kinds made up."""

from __future__ import annotations

import pytest

from eai.abilities.task import Task
from eai.data.store import Store
from eai.errors import DataError
from eai.households.behavior_1k.benchmark import behavior_1k
from eai.households.packs import BEHAVIOR_1K, open_published
from eai.tasks.source import Source, TaskSet


@pytest.fixture(scope="session")
def activity_store() -> Store:
    """The store with the activities, fetched once if they are not there."""
    store = Store()
    try:
        open_published(BEHAVIOR_1K, Source(store))
    except DataError as error:
        pytest.skip(f"BEHAVIOR-1K cannot be had: {error}")
    return store


@pytest.fixture(scope="session")
def activities(activity_store: Store) -> TaskSet[Task]:
    """The tasks of all activities."""
    return behavior_1k().tasks(Source(store=activity_store))
