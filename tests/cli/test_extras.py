"""Without the extras every command works, or says in a line which one it needs.

They are hidden, or not there: ``make test-bare`` names in ``EAI_BARE`` a Python for which the wheel is
installed by itself.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from eai.base.store import DataPackStore
from processes import Outcome
from studies.report.samples import action_run, goal_run, write_runs

LIBRARIES = (
    "gymnasium",
    "inspect_ai",
    "matplotlib",
    "mcp",
    "mlcroissant",
    "mujoco",
    "numpy",
    "openai",
    "pandas",
    "pyarrow",
    "scipy",
    "up_fast_downward",
    "yaml",
)
"""What the extras consist of."""

WITHOUT_THEM = f"""
import sys
sys.modules.update(dict.fromkeys({LIBRARIES}))
from eai.cli import main
main()
"""

BARE = os.environ.get("EAI_BARE")
START = [BARE, "-m", "eai"] if BARE else [sys.executable, "-c", WITHOUT_THEM]
"""What runs the command line without them."""

NEEDED = {
    "run --model eai/noisy --limit 2": "run",
    "score log.eval --domain behavior --ability action_sequencing": "run",
    "score m_outputs.parquet --domain behavior --ability action_sequencing": "analysis",
    "analyze table runs --out out --with formats=parquet": "analysis",
    "analyze cofactors runs --out out": "analysis",
    "analyze all runs --out out": "analysis",
    "data stats --distributions": "plots",
    "serve mcp --domain virtualhome --out out": "mcp",
    "serve mcp --tools": "mcp",
    "score m_outputs.json --domain behavior --ability transition_modeling --planner fast_downward": "planner",
}
"""Commands that cannot do without an extra."""

PROGRESS = re.compile(r"^.*: \d+/\d+\n", re.MULTILINE)
"""Lines on work that takes more than seconds, as on a busy machine."""

NO_PLOTS = "no plots: plots need matplotlib: pip install 'eai-bench[plots]'\n"

ONE_ANSWER = (
    "one: 341 of 342 tasks without an answer, counted as failed where they are in the statistics (336).\n"
)

SPARED = {
    "score one_outputs.json --domain virtualhome --ability action_sequencing --out scores": ONE_ANSWER,
    "report runs --out out": NO_PLOTS,
    "analyze errors runs --out out": NO_PLOTS,
    "analyze goals runs --out out": NO_PLOTS,
    "analyze table runs --out out": "",
    "explain runs --failed": "",
    "report runs": "",
    "data stats": "",
}
"""Commands that can, and what they say of it."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands speak of."""
    folder = tmp_path_factory.mktemp("bare")
    write_runs(folder / "runs", [action_run("first"), action_run("second"), goal_run()])
    (folder / "m_outputs.parquet").write_bytes(b"PAR1")
    (folder / "m_outputs.json").write_text("[]")
    (folder / "one_outputs.json").write_text('[{"identifier": "27_2", "llm_output": "{}"}]')
    (folder / "log.eval").write_bytes(b"PK")
    return folder


def bare(command: str, folder: Path) -> Outcome:
    """Run a command where no extra is installed."""
    done = subprocess.run(
        [*START, *command.split()],
        cwd=folder,
        env={**os.environ, "COLUMNS": "120", **({"PYTHONPATH": ""} if BARE else {})},
        capture_output=True,
        text=True,
        timeout=600,
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def must_name_the_extra(command: str, extra: str, place: Path) -> None:
    """Fail unless a command says in a line which extra it lacks."""
    outcome = bare(command, place)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith("eai: ")
    assert outcome.err.endswith(f": pip install 'eai-bench[{extra}]'\n")
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(("command", "extra"), NEEDED.items())
def test_a_missing_extra_is_one_line_that_names_it(
    command: str, extra: str, place: Path, data_store: DataPackStore
) -> None:
    must_name_the_extra(command, extra, place)


@pytest.mark.parametrize(("command", "note"), SPARED.items())
def test_what_can_do_without_does(command: str, note: str, place: Path, data_store: DataPackStore) -> None:
    outcome = bare(command, place)
    assert (outcome.status, PROGRESS.sub("", outcome.err)) == (0, note)
