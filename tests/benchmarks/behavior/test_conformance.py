from __future__ import annotations

import pytest

from benchmarks.behavior.kitchen import make_task
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.world.conformance import check
from eai.world.domain import Domain


@pytest.fixture
def domain() -> Domain:
    """The rules of the paper; tests of other rules for the same world have a fixture of this name, too."""
    return behavior.as_meant()


@pytest.fixture
def tolerated() -> frozenset[str]:
    """Defects that the rules are known to have."""
    return frozenset()


def test_it_conforms(domain: Domain, tolerated: frozenset[str]) -> None:
    assert {*check(domain, [make_task().initial], steps=1_000)} <= tolerated


def test_it_conforms_on_the_data_sets_scenes(
    behavior_tasks: BehaviorTasks, domain: Domain, tolerated: frozenset[str]
) -> None:
    assert {*check(domain, [task.initial for task in behavior_tasks.values()], steps=20)} <= tolerated


def test_there_are_the_papers_actions() -> None:
    assert len(behavior.as_meant().operators) == 30
