"""The real data of BEHAVIOR-1K."""

from __future__ import annotations

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.behavior_1k.benchmark import behavior_1k
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task


@pytest.fixture(scope="session")
def activities(activity_store: DataPackStore) -> TaskSet[Task]:
    """Return the tasks of all activities."""
    return behavior_1k().tasks(Source(store=activity_store))
