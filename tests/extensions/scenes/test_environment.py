"""Pictures of an environment: diagrams, and those of a camera."""

from __future__ import annotations

from importlib.util import find_spec

import gymnasium
import pytest
from gymnasium.error import ResetNeeded

from agents.switches import SWITCHES, WON
from agents.test_environment import TASKS
from eai.agents.gym import make
from eai.base.errors import EaiError, InputError
from eai.base.store import DataPackStore


def test_a_camera_shows_the_rooms_of_what_is_played(data_store: DataPackStore) -> None:
    if find_spec("mujoco") is None:
        pytest.skip("the extra physics is not installed")
    environment = gymnasium.make("eai/Behavior-v1", render_mode="camera")
    try:
        environment.reset(options={"task_id": TASKS["eai/Behavior-v1"]})
        before = environment.render()
    except EaiError as error:
        pytest.skip(str(error))
    assert (before.shape, before.dtype.name) == ((480, 640, 3), "uint8")
    environment.step("LEFT_GRASP(strawberry_0)")
    environment.step("OPEN(fridge_97)")
    environment.step("LEFT_GRASP(strawberry_0)")
    assert (environment.render() != before).any()
    environment.reset(options={"task_id": environment.unwrapped.task_ids[2]})
    assert (environment.render() != before).any()
    environment.close()


def test_a_world_without_bodies_is_not_rendered() -> None:
    if find_spec("mujoco") is None:
        pytest.skip("the extra physics is not installed")
    environment = make(SWITCHES, render_mode="camera")
    environment.reset(seed=0)
    with pytest.raises(InputError, match="cannot build a scene: this world needs the predicates"):
        environment.render()


@pytest.mark.parametrize(
    "rules", [{"observe": "full"}, {"observe": "partial"}, {"feedback": "outcome"}, {"feedback": "pictures"}]
)
def test_what_is_seen_can_be_drawn(rules: dict[str, str]) -> None:
    pytest.importorskip("matplotlib")
    environment = make(SWITCHES, render_mode="rgb_array", **rules)
    with pytest.raises(ResetNeeded):
        environment.render()
    environment.reset(seed=0)
    before = environment.render()
    assert before.shape[1:] == (1024, 3)
    assert before.dtype.name == "uint8"
    environment.step(WON[0])
    assert before.tobytes() != environment.render().tobytes()
