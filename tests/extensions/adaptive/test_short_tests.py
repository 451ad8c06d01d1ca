"""The short tests, and the tool that chooses them."""

from __future__ import annotations

from types import ModuleType

import pytest

from by_path import module_at
from eai.abilities.protocol import Ability, Protocol
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.extensions.adaptive.short_tests import short_test
from eai.extensions.adaptive.study import SuiteScores, collect_scores
from eai.tasks.source import Source
from oracle import MODELS
from studies.published import tables
from suites import SUITES

np = pytest.importorskip("numpy")


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    return module_at("tools/short_tests.py")


def scores(matrix: list[list[float]]) -> SuiteScores:
    tasks = tuple(map(str, range(len(matrix[0]))))
    return SuiteScores(tuple(map(str, range(len(matrix)))), tasks, tasks, np.array(matrix))


def test_easy_and_difficult_tasks_are_chosen_in_proportion(tool: ModuleType) -> None:
    """Of eight tasks, four easy, two of middle difficulty and two hard, every other one by difficulty."""
    found = scores([[1, 1, 1, 1, 0, 0, 0, 0], [1, 1, 1, 1, 1, 1, 0, 0], [1, 1, 1, 1, 1, 1, 1, 1]])
    assert tool.choose(found, 4) == ("1", "3", "5", "7")
    assert tool.choose(found, 8) == tool.choose(found, 9) == found.tasks


def test_a_short_test_keeps_the_order_of_models(tool: ModuleType) -> None:
    steps = [[float(task < 3 * model) for task in range(18)] for model in range(7)]
    found = tool.cross_validate(scores(steps), 6)
    assert found.chosen.ordered.percent == 100
    assert found.drawn.ordered.percent is not None
    assert found.drawn.ordered.percent < 100


def test_chosen_tasks_predict_scores_better_than_random_tasks(tool: ModuleType) -> None:
    """Every third of eighteen steps: of 3k steps climbed exactly k are asked, so that shares are equal."""
    steps = [[float(task < 3 * model) for task in range(18)] for model in range(7)]
    found = tool.cross_validate(scores(steps), 6)
    assert found.chosen.distance < 0.01 < 5 < found.drawn.distance


@pytest.mark.parametrize(("domain", "ability"), SUITES)
def test_every_suite_has_a_short_test_of_its_own_tasks(
    domain: str, ability: Ability, data_store: DataPackStore
) -> None:
    suite = open_suite(find_benchmark(domain), ability, source=Source(data_store))
    found = short_test(domain, ability)
    assert len(found) == 40
    assert [task for task in suite.task_ids if task in found] == list(found)


def test_the_short_test_is_the_one_that_is_chosen(tool: ModuleType) -> None:
    answers = tables("behavior", Ability.ACTION_SEQUENCING, MODELS, Protocol.STRICT).answers
    assert tool.choose(collect_scores(answers)) == short_test("behavior", Ability.ACTION_SEQUENCING)
