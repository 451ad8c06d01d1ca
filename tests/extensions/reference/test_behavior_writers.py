from __future__ import annotations

from collections.abc import Callable

import pytest

from abilities.test_behavior_writers import tasks, test_subgoals_of_the_annotated_plans_reach_the_goals
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecomposition
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecomposition

SHARED = (tasks, test_subgoals_of_the_annotated_plans_reach_the_goals)
"""A test of `strict`, with its fixture, that is run again with the fixtures below."""


@pytest.fixture
def scorer_of() -> Callable[[BehaviorTask], SubgoalDecomposition]:
    return BehaviorSubgoalDecomposition


@pytest.fixture
def reached() -> int:
    return 83
