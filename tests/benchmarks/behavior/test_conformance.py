from __future__ import annotations

from collections.abc import Iterable

import pytest

from benchmarks.behavior.kitchen import make_task
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTasks
from eai.world.conformance import check
from eai.world.domain import Domain
from eai.world.state import State
from protocols import of_reference

behavior_quirks = of_reference("behavior_quirks")

REFERENCES = (behavior_quirks.as_in_reference(), behavior_quirks.as_in_reference_subgoals())
BOTH = pytest.mark.parametrize(
    "domain", [behavior.as_meant(), *REFERENCES], ids=["strict", "eai-1.0.5", "eai-1.0.5 subgoals"]
)


def defects(domain: Domain, states: Iterable[State], steps: int) -> set[str]:
    """What does not conform, but for the hands of the reference (quirk `other_hand_is_additional`)."""
    known = {
        f"{side}_GRASP: an additional step that would bring about in_{side.lower()}_hand(x)"
        for side in ("LEFT", "RIGHT")
    }
    return {*check(domain, states, steps=steps)} - (known if domain in REFERENCES else set())


@BOTH
def test_it_conforms(domain: Domain) -> None:
    assert not defects(domain, [make_task().initial], steps=1_000)


@BOTH
def test_it_conforms_on_the_data_sets_scenes(behavior_tasks: BehaviorTasks, domain: Domain) -> None:
    assert not defects(domain, [task.initial for task in behavior_tasks.values()], steps=20)


def test_there_are_the_papers_actions() -> None:
    assert len(behavior.as_meant().operators) == 30
    assert {o.name for o in behavior_quirks.as_in_reference().operators} == {
        *(o.name for o in behavior.as_meant().operators),
        "BURN",
    }
