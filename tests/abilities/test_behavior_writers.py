from __future__ import annotations

from collections.abc import Callable

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.base.store import DataPackStore
from eai.benchmarks.behavior.notation import BehaviorSubgoalNotation
from eai.benchmarks.behavior.tasks import BehaviorTask, BehaviorTasks, open_tasks
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.source import Source
from subgoal_scorers import behavior_subgoals

WORDS = BehaviorSubgoalNotation()


@pytest.fixture(scope="module")
def tasks(data_store: DataPackStore) -> BehaviorTasks:
    return open_tasks(Source(data_store))


@pytest.fixture
def scorer_of() -> Callable[[BehaviorTask], SubgoalDecompositionScorer]:
    """Make scorers under `strict`. Tests of other protocols replace this fixture."""
    return behavior_subgoals()


@pytest.fixture
def reached() -> int:
    """Return the number of tasks whose goals are reached."""
    return 93


def test_subgoals_of_the_annotated_plans_reach_the_goals(
    tasks: BehaviorTasks, scorer_of: Callable[[BehaviorTask], SubgoalDecompositionScorer], reached: int
) -> None:
    verdicts = [scorer_of(task).score(WORDS.join(WORDS.write(task, task.script))) for task in tasks.values()]
    assert sum(bool(verdict.success) for verdict in verdicts) == reached


def test_a_plan_is_written_as_the_effects_of_its_actions(tasks: BehaviorTasks) -> None:
    task = next(t for t in tasks.values() if t.id.startswith("bringing_in_wood"))
    assert WORDS.write(task, task.script)[:4] == (
        "holds_rh(plywood.2)",
        "holds_lh(plywood.0)",
        "onfloor(plywood.0, room_floor_kitchen.0)",
        "onfloor(plywood.2, room_floor_kitchen.0)",
    )


def test_pouring_is_written_as_the_new_positions_of_objects(data_store: DataPackStore) -> None:
    source, ability = Source(data_store), Ability.SUBGOAL_DECOMPOSITION
    book = open_gold_answers(find_benchmark("behavior"), ability, source)
    (task_id,) = [each for each in book if each.startswith("preserving_food")]
    gold = book[task_id]
    assert (
        "inside(strawberry_61_part.0, jar.64) and inside(strawberry_61_part.1, jar.64) and "
        "inside(strawberry_62_part.0, jar.64) and inside(strawberry_62_part.1, jar.64)"
    ) in gold.parts
    assert open_suite("behavior", ability, source=source).scorer(task_id).score(gold.text).success
