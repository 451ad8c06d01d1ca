"""TRL trains a tiny model for real: on certificates, by rewards of whole plans, and action by action.

TRL and PyTorch exclude some libraries of the other tests, so `make test-adapters` runs these tests.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

TRAINING = EXAMPLES / "training"

LIBRARIES = ("torch", "trl", "transformers", "datasets", "matplotlib", "scipy")

pytestmark = pytest.mark.skipif(
    not all(map(find_spec, LIBRARIES)), reason=f"one of these is not installed: {', '.join(LIBRARIES)}"
)


def run(*command: object) -> None:
    """Run a Python program with the world of the lamps on its path."""
    environment = os.environ | {"PYTHONPATH": str(EXAMPLES / "lamps")}
    subprocess.run([sys.executable, *map(str, command)], check=True, env=environment)


def export_prompts(domain: object, folder: Path, prompt_set: str) -> None:
    """Write the prompts of a benchmark's plans for `datasets`."""
    suite = ("--domain", domain, "--ability", "action_sequencing", "--set", prompt_set)
    run("-m", "eai", "export", "prompts", *suite, "--format", "hf", "--out", folder)


def train_on_prompts(model: Path, prompts: Path, out: Path, *options: object) -> None:
    """Run one step of the example that trains a language model."""
    folders = ("--model", model, "--prompts", prompts, "--out", out)
    run(TRAINING / "trl_grpo.py", *folders, "--steps", 1, *options)


def test_trl_acts_in_a_household(tmp_path: Path) -> None:
    model, prompts, out = (tmp_path / name for name in ("model", "prompts", "trained"))
    export_prompts("lamps:lamps", prompts, "official")
    run(Path(__file__).parent / "tool_caller.py", model)
    train_on_prompts(model, prompts, out, "--acting", "--tokens", 120)
    state = json.loads(next(out.rglob("trainer_state.json")).read_text())
    metrics = state["log_history"][-1]
    assert metrics["tools/call_frequency"] > 0
    assert metrics["tools/failure_frequency"] == 0


def test_trl_learns_from_certificates_and_rewards(tmp_path: Path) -> None:
    small, prompts, out = (tmp_path / name for name in ("small", "prompts", "trained"))
    size = ("--seeds", 0, "--tasks", 40, 10, "--steps", 8, 2, 8, "--batch", 32)
    run(TRAINING / "small_transformer.py", "--out", small, *size)
    lines = [json.loads(line) for line in (small / "log.jsonl").read_text().splitlines()]
    assert {line["arm"] for line in lines} == {"start", "rewards", "certificates", "shuffled"}
    assert all("reward" in line for line in lines if line["arm"] in ("rewards", "shuffled"))
    assert (small / "curve.svg").exists()

    export_prompts(small / "train.jsonl", prompts, "facts")
    train_on_prompts(small / "start-0", prompts, out, "--tokens", 60)
    assert (out / "model.safetensors").exists()
