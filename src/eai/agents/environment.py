"""Play the tasks of a benchmark as a gymnasium environment."""

from __future__ import annotations

import string
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import gymnasium
from gymnasium.error import ResetNeeded

from eai.abilities.protocol import Ability
from eai.agents.command import MAX_LENGTH
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.observation import make_manual
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.base.entry_points import get_entry_points, load_from_extension
from eai.base.errors import InputError, did_you_mean
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.tasks.task import Task

MAX_OBSERVATION = 1 << 16
"""Maximum number of characters of an observation."""


@dataclass(unsafe_hash=True)
class AnyTextSpace(gymnasium.Space[str]):
    """A gymnasium space of all texts up to a length, with any characters. Samples are printable ASCII.

    `gymnasium.spaces.Text` allows only a fixed set of characters. In its default shared
    memory, `gymnasium.vector.AsyncVectorEnv` loses observations of a `Text` space. With `AnyTextSpace`,
    `AsyncVectorEnv` raises an error that asks for ``shared_memory=False``.
    """

    max_length: int

    def __post_init__(self) -> None:
        super().__init__(dtype=str)

    def sample(self, mask: None = None, probability: None = None) -> str:
        """Return a text of random printable characters."""
        length = int(self.np_random.integers(self.max_length + 1))
        return "".join(
            [string.printable[i] for i in self.np_random.integers(len(string.printable), size=length)]
        )

    def contains(self, x: Any) -> bool:
        """Whether this space contains a value: a text of at most `max_length` characters."""
        return isinstance(x, str) and len(x) <= self.max_length

    @property
    def is_np_flattenable(self) -> bool:
        """False, because a text cannot be flattened to an array."""
        return False


RENDER_MODE, CAMERA = "rgb_array", "camera"
"""Render modes: a diagram of the visible objects, or a camera near the agent in a scene with 3D bodies."""

_MODES = (RENDER_MODE, CAMERA)


class TextEnvironment(gymnasium.Env[str, str]):
    """A benchmark played by text: an action is a line such as ``GRAB(soap.1002)``.

    An action may also be a step in the notation of the benchmark's answers. An unreadable or impossible
    action, or an action on an unknown object, changes nothing but counts as an action.

    Args:
        benchmark: the benchmark.
        task_ids: ids of the tasks; each reset chooses one of them at random.
        rules: the rules of the games.
        tasks: all tasks by id.
        render_mode: ``rgb_array`` for diagrams of the visible objects (`render`), ``camera`` for rendered
            pictures, or None.

    Attributes:
        benchmark: the benchmark.
        rules: the rules of the games.
        task_ids: ids of the tasks; each reset chooses one of them at random.
    """

    metadata: dict[str, Any] = {"render_modes": [RENDER_MODE], "render_fps": 1}  # noqa: RUF012 - gymnasium's form

    def __init__(
        self,
        benchmark: Benchmark,
        task_ids: Sequence[str],
        rules: GameRules,
        tasks: Mapping[str, Task],
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in _MODES:
            modes = ", ".join(map(repr, _MODES))
            raise InputError(f"render_mode: expected {modes} or None, not {render_mode!r}")
        # few worlds have 3D scenes for camera pictures, so metadata lists this mode only on request
        if render_mode == CAMERA:
            self.metadata = {**self.metadata, "render_modes": [*_MODES]}
        # gymnasium's environment checker renders in every mode listed here
        elif "diagrams" not in get_entry_points("eai.offers"):
            self.metadata = {**self.metadata, "render_modes": []}
        self.render_mode = render_mode
        self.benchmark = benchmark
        self.rules = rules
        self.action_space = AnyTextSpace(MAX_LENGTH)
        self.observation_space = AnyTextSpace(MAX_OBSERVATION)
        self._tasks = tasks
        self.task_ids = tuple(task_ids)
        self._game: Game | None = None
        self._epoch = -1
        self._camera: Any = None

    @cached_property
    def manual(self) -> str:
        """The manual for an agent: a text on the predicates and actions of the world."""
        return make_manual(self.benchmark, self.rules)

    @property
    def game(self) -> Game:
        """The current game, for agents that read its state (`eai.agents.agents`).

        Raises:
            ResetNeeded: no game has begun.
        """
        if self._game is None:
            raise ResetNeeded("no game has begun: call reset")
        return self._game

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[str, dict[str, Any]]:
        """Begin a new game.

        Return two values: the first observation, with instruction, goals and objects, and a mapping with
        further information.

        Args:
            seed: the seed of the choice among several tasks, and of slips (possible actions that by chance
                have no effect). Equal seeds give equal games in equal order.
            options: ``task_id`` names the task to play.

        Raises:
            InputError: the benchmark has no such task, or the task has no goals.
        """
        super().reset(seed=seed)
        self._epoch = 0 if seed is not None else self._epoch + 1
        wanted: str | None = (options or {}).get("task_id")
        setup = self._open_setup(self._choose_random_task_id() if wanted is None else wanted)
        self._game = Game(setup, self.np_random_seed or 0, self._epoch)
        return self._game.write_first_observation(), {**self._game.make_gymnasium_info()}

    def step(self, action: str) -> tuple[str, float, bool, bool, dict[str, Any]]:
        """Play one turn. Return gymnasium's five values.

        They are the observation, the reward, whether the rules ended the game, whether a limit cut it off,
        and further information.

        Raises:
            ResetNeeded: no game has begun, or the last game is over.
        """
        if self._game is None or self._game.is_over:
            raise ResetNeeded("the episode is over or has not begun: call reset")
        observation, reward, terminated, truncated, info = self._game.act(action)
        return observation, reward, terminated, truncated, {**info}

    def render(self) -> Any:
        """Return a picture of the present world, as an array of height x width x 3 colours of 8 bits.

        A diagram shows the objects that the agent sees. A camera stands in the room; doors and walls hide
        objects from it.

        Returns:
            the array; None without a render mode.

        Raises:
            ResetNeeded: no game has begun.
            EaiError: the extra that draws pictures is not installed, or the scene has no bodies.
        """
        if self.render_mode is None:
            return None
        if self.render_mode == CAMERA:
            camera = self._open_camera()
            camera.scene.show_state(self.game.state)
            return camera.render_colours("near")
        observation = self.game.memory.observation
        draw_scene_as_array = load_from_extension(
            "diagrams", f"render_mode {RENDER_MODE}"
        ).draw_scene_as_array
        return draw_scene_as_array(self.game.task, self.benchmark, observation.state, observation.visible)

    def close(self) -> None:
        """Close the camera and free its memory."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def _open_camera(self) -> Any:
        if self._camera is None or self._camera.scene.task is not self.game.task:
            self.close()
            self._camera = load_from_extension("rendered_pictures", f"render_mode {CAMERA}").open_camera(
                self.game.task
            )
        return self._camera

    def _choose_random_task_id(self) -> str:
        """Return a random task's id. Tasks without goals are drawn only if no task has goals."""
        order = [self.task_ids[int(i)] for i in self.np_random.permutation(len(self.task_ids))]
        return next(
            (task_id for task_id in order if self._tasks[task_id].unplannable_reason is None),
            order[0],
        )

    def _open_setup(self, task_id: str) -> GameSetup:
        _check_task_ids((task_id,), self._tasks, self.benchmark)
        return make_setup(self._tasks[task_id], self.benchmark, self.rules)


def make(
    benchmark: Benchmark | str,
    task_id: str | Sequence[str] | None = None,
    *,
    render_mode: str | None = None,
    source: Source | None = None,
    rules: GameRules | None = None,
    **options: Any,
) -> TextEnvironment:
    """Make the environment of a benchmark.

    Args:
        benchmark: its name, ``module:object``, or a `Benchmark`.
        task_id: the task; several tasks, from which each reset draws one; or None for all tasks with goals.
        render_mode: ``rgb_array`` for diagrams of the visible objects, ``camera`` for rendered pictures, or
            None.
        source: the source of the data, fetched on first use; the user's default store if None.
        rules: the rules of the games, such as `eai.agents.rules.STANDARD`; `GameRules()` if None.
        options: fields of `GameRules` with other values than in ``rules``, such as ``slip=0.1,
            until="done"``.

    Raises:
        InputError: the benchmark, a task or an option does not exist, or an option has an invalid value.
        DataError: the data cannot be fetched.
    """
    found = find_benchmark(benchmark) if isinstance(benchmark, str) else benchmark
    read = GameRules.read("make", {**dict(rules or GameRules()), **options})
    source = source or Source()
    tasks = found.tasks_for(Ability.ACTION_SEQUENCING, source)
    task_ids = (task_id,) if isinstance(task_id, str) else tuple(tasks if task_id is None else task_id)
    if not task_ids:
        raise InputError(f"task_id: expected at least one task of {found.name}, or None for all")
    _check_task_ids(task_ids, tasks, found)
    return TextEnvironment(found, task_ids, read, tasks, render_mode)


def _check_task_ids(task_ids: Sequence[str], tasks: Collection[str], benchmark: Benchmark) -> None:
    for task_id in task_ids:
        if task_id not in tasks:
            raise InputError(f"{benchmark.name} has no task {task_id!r}{did_you_mean(task_id, tasks)}")
