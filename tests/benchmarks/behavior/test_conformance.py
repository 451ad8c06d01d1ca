from __future__ import annotations

import pytest

from benchmarks.behavior.kitchen import make_task
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.world.conformance import check_domain
from eai.world.domain import Domain


@pytest.fixture
def domain() -> Domain:
    """Return the domain with the paper's rules. Tests of other rules override this fixture."""
    return behavior.make_domain_with_checks_in_paper_order()


@pytest.fixture
def tolerated() -> frozenset[str]:
    """Return the known defects of the rules."""
    return frozenset()


def test_the_domain_conforms_to_its_declarations(domain: Domain, tolerated: frozenset[str]) -> None:
    assert {*check_domain(domain, [make_task().initial], steps=1_000)} <= tolerated


def test_the_domain_conforms_on_the_scenes_of_the_data_set(
    behavior_tasks: BehaviorTasks, domain: Domain, tolerated: frozenset[str]
) -> None:
    assert {*check_domain(domain, [task.initial for task in behavior_tasks.values()], steps=20)} <= tolerated


def test_the_domain_has_the_actions_of_the_paper() -> None:
    assert len(behavior.make_domain_with_checks_in_paper_order().operators) == 30
