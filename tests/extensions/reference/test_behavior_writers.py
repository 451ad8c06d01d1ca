from __future__ import annotations

from collections.abc import Callable

import pytest

from abilities.test_behavior_writers import tasks, test_subgoals_of_the_annotated_plans_reach_the_goals
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecompositionScorer

SHARED = (tasks, test_subgoals_of_the_annotated_plans_reach_the_goals)
"""A test of `strict`, with its fixture, that is run again with the fixtures below."""


@pytest.fixture
def scorer_of() -> Callable[[BehaviorTask], SubgoalDecompositionScorer]:
    return BehaviorSubgoalDecompositionScorer


@pytest.fixture
def reached() -> int:
    return 83
