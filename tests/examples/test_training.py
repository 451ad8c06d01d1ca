"""Tests that the training example learns, in a world so small that it takes seconds."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from by_path import ROOT

EXAMPLES = ROOT / "examples"


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    pytest.importorskip("numpy")
    for folder in ("training", "lamps"):
        monkeypatch.syspath_prepend(EXAMPLES / folder)
    for name in ("train", "policy"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return import_module("train")


def test_a_policy_that_learns_wins_more_than_one_that_does_not(example: ModuleType) -> None:
    """Both policies start equal; each plays both tasks of lamps twenty times."""
    playing = example.environment("lamps:lamps")
    policy, untrained = example.Table(seed=0), example.Table(seed=0)
    for update in range(30):
        task = playing.task_ids[update % 2]
        example.learn(policy, [example.play(playing, policy, task) for _ in range(example.TOGETHER)])
    learned = sum(example.evaluate(playing, policy) for _ in range(20))
    by_chance = sum(example.evaluate(playing, untrained) for _ in range(20))
    assert by_chance < 20 < learned


def test_the_return_of_a_turn_sums_its_reward_and_later_ones(example: ModuleType) -> None:
    assert example.returns([0, 0.5, -0.5]) == pytest.approx([0.045, 0.05, -0.5])


def test_a_learning_curve_begins_with_the_untrained_policy(example: ModuleType, tmp_path: Path) -> None:
    playing = example.environment("lamps:lamps")
    points = list(example.train(playing, playing, seed=1, updates=2, every=1))
    assert [(point.episodes, point.tasks) for point in points] == [(0, 2), (8, 2), (16, 2)]
    example.draw([points, points], tmp_path / "curve.png")
    assert (tmp_path / "curve.png").stat().st_size > 1000
