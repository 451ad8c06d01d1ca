from __future__ import annotations

import pytest

from benchmarks.behavior.test_conformance import (
    test_the_domain_conforms_on_the_scenes_of_the_data_set,
    test_the_domain_conforms_to_its_declarations,
)
from eai.benchmarks.behavior.domain import make_domain_with_checks_in_paper_order
from eai.extensions.reference.behavior_quirks import (
    make_domain_with_all_quirks,
    make_subgoal_domain_with_all_quirks,
)
from eai.world.domain import Domain

SHARED = (
    test_the_domain_conforms_to_its_declarations,
    test_the_domain_conforms_on_the_scenes_of_the_data_set,
)
"""Tests of the paper's rules, which are run again with the fixtures below."""


@pytest.fixture(
    params=[make_domain_with_all_quirks, make_subgoal_domain_with_all_quirks], ids=["plans", "subgoals"]
)
def domain(request: pytest.FixtureRequest) -> Domain:
    declared: Domain = request.param()
    return declared


@pytest.fixture
def tolerated() -> frozenset[str]:
    """The hands of the reference (quirk `report_grasp_from_other_hand_as_additional_step`)."""
    return frozenset(
        f"{side}_GRASP: an additional step that would bring about in_{side.lower()}_hand(x)"
        for side in ("LEFT", "RIGHT")
    )


def test_there_is_one_action_more_than_the_papers() -> None:
    names = {operator.name for operator in make_domain_with_checks_in_paper_order().operators}
    assert {operator.name for operator in make_domain_with_all_quirks().operators} == {*names, "BURN"}
