"""Run and measure the reference package, `eai-eval`, in a separate environment.

The environment (600 MB, built once) is in the user's cache directory.

Transition modeling is left out, because its evaluation imports a planner's package and needs a compiled
planner. BEHAVIOR is left out, because its evaluation loads the iGibson simulator and its licensed assets.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import platformdirs

REFERENCE = "eai-eval==1.0.5"
IMPORTED = ("fire", "lark", "numpy")  # the imports of the three evaluations; the package declares far more
CHILD = Path(__file__).with_name("reference_child.py")
CACHE = platformdirs.user_cache_path("eai-bench")


class Ability(Enum):
    """Abilities whose evaluation can run here in the reference package."""

    GOAL_INTERPRETATION = "goal_interpretation"
    SUBGOAL_DECOMPOSITION = "subgoal_decomposition"
    ACTION_SEQUENCING = "action_sequencing"


@dataclass(frozen=True, slots=True)
class Response:
    """A model's answer to a task. `task_id` has no scene prefix, as in `27_2`."""

    task_id: str
    text: str


@dataclass(frozen=True, slots=True)
class Measurement:
    """Cost and results of the reference package's evaluation of some responses.

    Attributes:
        tasks: Number of responses evaluated.
        startup_cpu_seconds: User and system time of the interpreter's start and the imports.
        cpu_seconds: User and system time of the evaluation alone.
        peak_bytes: Maximum resident size of the process.
        python: Version of Python.
        results: Return value of the evaluation for the one model.
    """

    tasks: int
    startup_cpu_seconds: float
    cpu_seconds: float
    peak_bytes: int
    python: str
    results: Any

    @property
    def tasks_per_cpu_second(self) -> float:
        """Responses evaluated per second of processor time."""
        return self.tasks / self.cpu_seconds


def environment(cache: Path = CACHE) -> Path:
    """Return the Python of an environment with the reference package, built on first use.

    Raises:
        subprocess.CalledProcessError: The environment could not be made, or the package not installed.
    """
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    folder = cache / f"{REFERENCE.replace('==', '-')}-python{version}"
    python = folder / "bin" / "python"
    complete = folder / "complete"
    if not complete.exists():
        print(f"installing {REFERENCE} into {folder}", file=sys.stderr)
        shutil.rmtree(folder, ignore_errors=True)
        install = create(folder, python)
        subprocess.run([*install, *IMPORTED], check=True, stdout=sys.stderr)
        subprocess.run([*install, "--no-deps", REFERENCE], check=True, stdout=sys.stderr)
        complete.touch()
    return python


def package_folder(python: Path) -> Path:
    """Return the folder of the reference package for VirtualHome in an environment, with its data set."""
    return next(python.parents[1].glob("lib/python*/site-packages/virtualhome_eval"))


def create(folder: Path, python: Path) -> list[str]:
    """Make an empty environment with the standard library, or else uv, and return its install command."""
    venv = subprocess.run([sys.executable, "-m", "venv", str(folder)], check=False, capture_output=True)
    if venv.returncode == 0:
        return [str(python), "-m", "pip", "install", "--quiet"]
    subprocess.run(
        ["uv", "venv", "--quiet", "--allow-existing", "--python", sys.executable, str(folder)], check=True
    )
    return ["uv", "pip", "install", "--quiet", "--python", str(python)]


def write_responses(path: Path, responses: list[Response], prefix: str = "") -> None:
    """Write a response file in the reference package's format."""
    rows = [{"identifier": prefix + response.task_id, "llm_output": response.text} for response in responses]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(rows), encoding="utf-8")


def evaluate(python: Path, ability: Ability, responses: list[Response]) -> Measurement:
    """Evaluate some responses with the reference package and one worker, and measure the cost.

    Raises:
        subprocess.CalledProcessError: The reference package crashed; its traceback is on standard error.
    """
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as name:
        folder = Path(name)
        prefix = "scene_1_" if ability is Ability.SUBGOAL_DECOMPOSITION else ""
        write_responses(
            folder / "in" / "virtualhome" / ability.value / "model_outputs.json", responses, prefix
        )
        command = [
            str(python),
            "-W",
            "ignore",
            str(CHILD),
            ability.value,
            str(folder / "in"),
            str(folder / "out"),
        ]
        child = subprocess.run(
            command,
            check=True,
            stdout=subprocess.PIPE,
            text=True,
            cwd=folder,
            env=os.environ | {"PYTHONHASHSEED": "0"},
        )
    report = json.loads(child.stdout.splitlines()[-1])
    results = report.pop("results")
    return Measurement(tasks=len(responses), results=results["model"], **report)
