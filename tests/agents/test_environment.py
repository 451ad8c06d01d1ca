"""Environments as gymnasium makes them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import warnings
from dataclasses import replace
from itertools import chain
from pathlib import Path
from random import Random

import gymnasium
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from agents.switches import SWITCHES, WON
from by_path import ROOT
from eai.agents.gym import ANY, IDS, AnyTextSpace, make
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.tasks.source import Source
from eai.world import Operator, SlipSampler

LAMPS = ROOT / "examples" / "lamps" / "lamps.py"
TASKS = {
    "eai/VirtualHome-v1": "27_2",
    "eai/Behavior-v1": "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46",
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Change into a folder with the example's file, as its author would."""
    shutil.copy(LAMPS, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


def test_every_benchmark_of_the_package_has_an_id() -> None:
    assert {*IDS} == {*TASKS}
    assert {*IDS, ANY} <= {*gymnasium.registry}


@pytest.mark.parametrize(
    ("name", "options"),
    [("DONE", {"until": "done"}), ("LOOK", {"until": "done"}), ("LOOK", {"feedback": "changes"})],
)
def test_no_action_has_the_name_of_a_command(name: str, options: dict[str, str]) -> None:
    domain = replace(SWITCHES.domain, operators=(Operator(name, (), (), ()), *SWITCHES.domain.operators))
    environment = make(replace(SWITCHES, domain=domain), **options)
    with pytest.raises(InputError, match=f"the command {name} .* so no action may have this name"):
        environment.reset(seed=0)


@pytest.mark.parametrize("options", [{}, {"observe": "partial", "reward": "progress", "slip": 0.5}])
@pytest.mark.parametrize("name", TASKS)
def test_gymnasiums_own_check_finds_nothing(
    name: str, options: dict[str, object], data_store: DataPackStore
) -> None:
    source = Source(data_store)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, task_id=TASKS[name], source=source, **options).unwrapped)
        check_env(gymnasium.make(name, source=source, **options).unwrapped)


def test_any_benchmark_is_made_by_its_reference(here: None) -> None:
    environment = gymnasium.make(ANY, benchmark="lamps:lamps", task_id="light", max_steps=5)
    assert environment.reset(seed=0)[0].startswith("light\nSwitch both lamps on.")
    played = [
        environment.step(f"{action}({lamp})") for lamp in ("lamp_1", "lamp_2") for action in ("GO", "PRESS")
    ]
    assert played[-1][2]
    assert played[-1][4]["won"]


def test_a_domain_without_visibility_shows_everything(here: None) -> None:
    full, partial = [make("lamps:lamps", "pack", observe=observe) for observe in ("full", "partial")]
    facts = [each.reset(seed=0)[0].partition("Objects")[2] for each in (full, partial)]
    assert facts[0] == facts[1]


def test_a_step_needs_a_reset() -> None:
    environment = make(SWITCHES, "both")
    with pytest.raises(ResetNeeded):
        environment.step("WAVE")
    environment.reset()
    for command in WON:
        environment.step(command)
    with pytest.raises(ResetNeeded):
        environment.step("WAVE")


def test_a_text_of_any_characters_is_in_the_space() -> None:
    space = AnyTextSpace(5)
    assert "" in space
    assert "é 漢\n" in space
    assert "12345" in space
    assert "123456" not in space
    assert 3 not in space
    space.seed(0)
    assert {len(space.sample()) for _ in range(100)} == {0, 1, 2, 3, 4, 5}


def test_each_game_after_a_seed_has_the_slips_of_the_next_epoch() -> None:
    environment = make(SWITCHES, "both", slip=0.5)
    for epoch in range(3):
        environment.reset(seed=7 if epoch == 0 else None)
        slipped = [environment.step("PRESS(lamp)")[4]["slipped"] for _ in range(8)]
        luck = SlipSampler(0.5, "both", seed=7, epoch=epoch)
        assert slipped == [luck.draw_whether_next_action_slips() for _ in range(8)]


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vector_environments_play_in_parallel(mode: str, here: None) -> None:
    environments = gymnasium.make_vec(
        ANY,
        num_envs=2,
        vectorization_mode=mode,
        vector_kwargs={"shared_memory": False} if mode == "async" else {},
        benchmark="lamps:lamps",
        task_id="light",
    )
    observations, infos = environments.reset(seed=[1, 2])
    assert observations[0] == observations[1]
    assert list(infos["task_id"]) == ["light", "light"]
    for command in chain(*[(f"GO({lamp})", f"PRESS({lamp})") for lamp in ("lamp_1", "lamp_2")]):
        _, rewards, terminated, _, infos = environments.step((command, "GO(ball)"))
    assert list(rewards) == [1.0, 0.0]
    assert list(terminated) == list(infos["won"]) == [True, False]
    assert infos["fault"][1] == "additional_step"
    observations, *_ = environments.step(("GO(ball)", "GO(ball)"))
    assert observations[0].startswith("light"), "a game that is over begins again"
    environments.close()


def test_shared_memory_is_refused_for_texts(here: None) -> None:
    with pytest.raises(ValueError, match="shared_memory=False"):
        gymnasium.make_vec(ANY, num_envs=2, vectorization_mode="async", benchmark="lamps:lamps")


def test_without_gymnasium_an_error_tells_how_to_install_it() -> None:
    without = "import sys; sys.modules['gymnasium'] = None; "
    code = without + "import eai.agents.rewards; from eai.agents.gym import make"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install 'eai-bench[envs]'" in result.stderr.splitlines()[-1]


def test_no_picture_is_drawn_without_a_render_mode() -> None:
    environment = make(SWITCHES)
    environment.reset()
    assert environment.render() is None
    with pytest.raises(InputError, match="render_mode"):
        make(SWITCHES, render_mode="human")


def played(seed: int) -> list[str]:
    env, rng = make(SWITCHES, task_id="both", admissible=True, max_steps=40), Random(seed)
    _, info = env.reset(seed=0)
    commands, ended = [], False
    while not ended:
        commands.append(rng.choice(info["admissible_commands"]))
        _, _, terminated, truncated, info = env.step(commands[-1])
        assert info["fault"] is None
        ended = terminated or truncated
    return commands


def test_admissible_commands_succeed() -> None:
    assert len({tuple(played(seed)) for seed in range(4)}) > 1
