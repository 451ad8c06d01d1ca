"""Scenes with bodies: a task's initial state arranged, settled by MuJoCo, and seen to hold by geometry.

Sizes are ours (`kinds.txt`), so a scene decides no verdict. Only this module and `camera` load MuJoCo.
"""

from __future__ import annotations

import os
import sys
from ctypes.util import find_library
from typing import TYPE_CHECKING, Any

import numpy as np

from eai.abilities.task import Task
from eai.bodies import geometry
from eai.bodies.arranging import arranged, place_rest
from eai.bodies.body import Array
from eai.bodies.looks import painted, specks
from eai.bodies.model import model_text
from eai.bodies.placing import Placing, Pose
from eai.bodies.told import BESIDE, INSIDE, ON, UNDER, Told, told_of
from eai.errors import InputError
from eai.world.state import State

if TYPE_CHECKING:
    import mujoco

ATTEMPTS = 8
"""How often a scene is arranged anew where something falls or finds no place, at most."""

_STEPS, _CHUNK = 240, 8
"""How many steps of 4 ms a scene has to come to rest, and after how many its motion is damped."""

_STILL = 0.03
"""The speed below which everything is at rest, in m/s and radians/s."""

_PARKED = (0.0, 0.0, -30.0)
"""Where things are that are not there."""


def _load_mujoco() -> Any:
    """Return the library, which draws through EGL where there is one and nobody says otherwise."""
    if sys.platform == "linux" and "MUJOCO_GL" not in os.environ:
        os.environ["MUJOCO_GL"] = "egl" if find_library("EGL") else "disabled"
    import mujoco

    return mujoco


class BodyScene:
    """The scene of a task with bodies: all initial relations of its things hold by geometry.

    Args:
        task: the task.

    Attributes:
        task: the task.
        told: everything that is told of the state shown, the initial one at first.
        rooms: the box of each room, by the index of its floor.
        attempts: how often it was arranged.
        mujoco: the library.
        model: the model of MuJoCo.
        data: its state.
        bodies: the body of each thing in the model.
        geoms: the geoms of each thing, one a part.

    Raises:
        InputError: it cannot be arranged; says why.
        ImportError: MuJoCo is not installed.
    """

    def __init__(self, task: Task) -> None:
        self.mujoco = _load_mujoco()
        self.task = task
        self._names = [thing.name for thing in task.scene.objects]
        self.told = told_of(task.initial)
        self._bodies = {**self.told.bodies, **self.told.absent}
        problem: InputError | None = None
        for self.attempts in range(1, ATTEMPTS + 1):
            try:
                self._settle(f"{task.id} 0 {self.attempts}")
            except InputError as error:
                problem = error
                continue
            return
        raise InputError(f"{task.id}: {problem}") from problem

    def _settle(self, seed: str) -> None:
        """Arrange everything, let it settle, and see whether it is where it should be.

        Raises:
            InputError: it is not, or found no place.
        """
        placing, self.rooms = arranged(self.told, self._names, seed)
        self._make(placing)
        self._rest()
        lost = self.lost()
        if lost:
            first, relation, second = lost[0]
            raise InputError(f"{self._names[first]} does not keep {relation} {self._names[second]}")

    def _make(self, placing: Placing) -> None:
        """Make the model."""
        text = model_text(placing, self.told, self.rooms, _PARKED)
        self.model: mujoco.MjModel = self.mujoco.MjModel.from_xml_string(text)
        self.data: mujoco.MjData = self.mujoco.MjData(self.model)
        find, kind = self.mujoco.mj_name2id, self.mujoco.mjtObj.mjOBJ_BODY
        self.bodies = {thing: find(self.model, kind, f"b{thing}") for thing in self._bodies}
        first, many = self.model.body_geomadr, self.model.body_geomnum
        self.geoms = {i: range(first[b], first[b] + many[b]) for i, b in self.bodies.items()}
        self.mujoco.mj_forward(self.model, self.data)

    def _rest(self) -> None:
        """Let things come to rest, their motion damped so that nothing rolls away."""
        mj, model, data = self.mujoco, self.model, self.data
        for step in range(0, _STEPS, _CHUNK):
            mj.mj_step(model, data, _CHUNK)
            if step > _CHUNK and (not model.nv or abs(data.qvel).max() < _STILL):
                break
            data.qvel *= 0.75
        data.qvel[:] = 0
        mj.mj_forward(model, data)

    def show(self, state: State) -> None:
        """Show another state of the task: what is said to be where it was stays, all else is put anew.

        Nothing falls. What finds no place is shown in the middle of where it should be.

        Raises:
            InputError: a thing has no body.
        """
        before, told = self.told, told_of(state)
        placing = Placing(told, self._names, f"{self.task.id} {hash(state)}")
        kept = self._kept(before, told)
        for thing in kept:
            placing.put(thing, self._pose(thing))
        place_rest(placing, told, self.rooms, crowded=True)
        for thing in self._bodies:
            if thing not in kept:
                self.move(thing, placing.poses.get(thing, Pose(_PARKED)))
            self._paint(thing, placing)
        self.told = told
        self.mujoco.mj_forward(self.model, self.data)

    def _kept(self, before: Told, told: Told) -> list[int]:
        """The things that are where they were, those that carry others first."""
        kept: list[int] = []
        moved = {*before.hands.values(), *told.hands.values()}
        for thing in sorted(told.bodies, key=told.depth):
            carrier = told.carrier(thing)
            stays = thing in before.bodies and thing not in moved and before.place(thing) == told.place(thing)
            if stays and (carrier is None or carrier[1] in kept):
                kept.append(thing)
        return kept

    def _pose(self, thing: int) -> Pose:
        body = self.bodies[thing]
        x, y, z = self.data.xpos[body].tolist()
        a, b, c, d = self.data.xquat[body].tolist()
        return Pose((x, y, z), (a, b, c, d))

    def _paint(self, thing: int, placing: Placing) -> None:
        """Show the parts of a thing that are there in its states, in their colours."""
        body = self._bodies[thing]
        states = placing.states.get(thing, frozenset())
        for geom, part in zip(self.geoms[thing], (*body.parts, *specks(body)), strict=True):
            seen = thing in placing.bodies and (not part.when or part.when in states)
            self.model.geom_rgba[geom] = (*painted(part.colour, states), float(seen))
            self.model.geom_contype[geom] = int(seen and part.is_solid)

    def front(self, thing: int) -> Array:
        """The way to the front of a thing, level: three numbers."""
        axes = self.data.xmat[self.bodies[thing]].reshape(3, 3)
        way: Array = -axes[:, 1] if abs(axes[2, 1]) < 0.5 else np.array([0.0, -1.0, 0.0])
        return way

    def move(self, thing: int, pose: Pose) -> None:
        """Put a thing somewhere; nothing gives way."""
        body = self.bodies[thing]
        if self.model.body_dofnum[body]:
            start = self.model.jnt_qposadr[self.model.body_jntadr[body]]
            self.data.qpos[start : start + 7] = (*pose.at, *pose.turn)
        else:
            self.model.body_pos[body], self.model.body_quat[body] = pose.at, pose.turn
        self.mujoco.mj_kinematics(self.model, self.data)

    def lost(self) -> list[tuple[int, str, int]]:
        """The relations that are told and do not hold by geometry."""
        told = self.told
        tests = {
            INSIDE: geometry.inside,
            ON: geometry.on_top,
            UNDER: geometry.under,
            BESIDE: geometry.next_to,
        }
        lost = [
            (first, relation, second)
            for relation, test in tests.items()
            for first, second in told.relations[relation]
            if not test(self, first, second)
        ]
        on_floor = [(i, floor) for i, floor in told.floor_of.items() if told.carrier(i) is None]
        outside = [
            (i, "on the floor of", f) for i, f in on_floor if not geometry.on_floor(self, i, self.rooms[f])
        ]
        return lost + [each for each in outside if each[0] not in told.hands.values()]
