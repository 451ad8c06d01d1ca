from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from base.test_entry_points import declared
from command_line import Command
from eai import __version__
from eai.base.entry_points import get_entry_points
from eai.cli import app

NAP = """
import sys, time
from eai import cli

@cli.app.command()
def nap() -> None:
    try:
        print("asleep", flush=True)
        time.sleep(60)
    finally:
        print("cleaned up", flush=True)

sys.argv = ["eai", "nap"]
cli.main()
"""


def test_a_request_to_terminate_is_an_ordinary_exit() -> None:
    with subprocess.Popen([sys.executable, "-c", NAP], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "asleep\n"
        process.send_signal(signal.SIGTERM)
        assert process.stdout.readline() == "cleaned up\n"
        assert process.wait(120) == 143


INTERRUPTED_IMPORT = """
import signal, sys
from importlib.abc import MetaPathFinder

class Interrupt(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "eai.cli.score":
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
sys.argv = ["eai", "score", "answers.json"]
from eai.__main__ import main
main()
"""


def test_an_interrupt_while_a_command_is_imported_is_one_line() -> None:
    command = [sys.executable, "-c", INTERRUPTED_IMPORT]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "eai: interrupted\n")


def test_an_interrupted_command_is_one_line() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", NAP], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == "asleep\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(120) == 130
        assert process.stderr.read() == "eai: interrupted\n"


HIT_WHILE_IT_EVALUATED = """
import signal, sys
import eai.cli.console  # or what is imported for the message evaluates some more
from eai import cli
from eai.__main__ import main

@cli.app.command()
def nap() -> None:
    exec("signal.raise_signal(signal.SIGINT)", {"signal": signal})

sys.argv = ["eai", "nap"]
main()
"""

HIT_AT_THE_END = """
import os, signal, sys
from eai.__main__ import main

class Late:
    def __del__(self, hit=os.kill, me=os.getpid(), number=signal.SIGINT):
        hit(me, number)

late = Late()
sys.argv = ["eai", "--version"]
main()
"""


@pytest.mark.parametrize(
    ("program", "status", "told"),
    [(HIT_WHILE_IT_EVALUATED, 130, "eai: interrupted\n"), (HIT_AT_THE_END, 0, "")],
    ids=["while it evaluated a text", "at the end"],
)
def test_no_interrupt_ends_the_process_by_the_signal(
    tmp_path: Path, program: str, status: int, told: str
) -> None:
    """Python does, where it evaluated a text at the time or takes itself down already; run as a module."""
    (tmp_path / "program.py").write_text(program)
    done = subprocess.run(
        [sys.executable, "-m", "program"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (status, told)


LOADED = """
import sys
from eai import cli
cli.app(["demo", "--help"], standalone_mode=False)
print(*[name for name in sys.modules if name.startswith("eai.cli.")])
"""


def test_only_the_command_that_is_asked_for_is_imported() -> None:
    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True)
    loaded = done.stdout.splitlines()[-1].split()
    assert "eai.cli.demo" in loaded
    assert not {"eai.cli.analyze", "eai.cli.run", "eai.cli.score"}.intersection(loaded)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            "run --set fact",
            "Invalid value for '--set': 'fact' is not one of 'official', 'eai', ",
        ),
        ("export prompts --set fact", "'short', 'facts'; did you mean facts?"),
        ("run --set zzzz", "'short', 'facts'. "),
        ("run --limit 0", "Invalid value for '--limit': expected greater than or equal to 1"),
    ],
)
def test_a_wrong_value_is_told_in_plain_words(eai: Command, arguments: str, message: str) -> None:
    done = eai(*arguments.split())
    assert done.status == 2
    told = " ".join(done.err.replace("│", "").split())
    assert message in told
    assert "Value error" not in told
    assert "Input should" not in told


COMMANDS = "eai.commands"


def test_help_has_the_summary_of_each_command_and_imports_none(eai: Command) -> None:
    known: Any = get_command(app)
    shown = " ".join(eai("--help").out.split())
    names = [name for name in get_entry_points(COMMANDS) if " " not in name]
    assert sorted(known.commands) == sorted(names)
    context = known.context_class(known, info_name="eai")
    for name in names:
        summary = known.commands[name].help.split("\n\n")[0]
        assert known.get_command(context, name).help == summary
        assert "`" not in summary
        assert f" {name} {summary.split()[0]} " in shown.replace("│ │", "│").replace("│", "")
    script = (
        "import sys; from eai import cli; cli.app(['--help'], standalone_mode=False); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = done.stdout.splitlines()[-1].split()
    assert not {value.partition(":")[0] for value in declared(COMMANDS).values()}.intersection(loaded)


NAPPING = '''
print("imported")


def nap(minutes: int = 10) -> None:
    """Do nothing for some ``minutes``: nothing is computed.

    Example: eai nap

    Options:
        minutes: How many.
    """
    print(f"slept for {minutes}")
'''


def test_a_distribution_adds_commands_at_the_top_and_below_a_group(tmp_path: Path) -> None:
    about = tmp_path / "napping-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: napping\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        f"[{COMMANDS}]\nnap = napping:nap\ndata nap = napping:nap\nscore nap = napping:nap\n"
    )
    (tmp_path / "napping.py").write_text(NAPPING)

    def ran(*words: str) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONPATH": str(tmp_path), "COLUMNS": "80"}
        command = [sys.executable, "-m", "eai", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)

    top = ran("--help").stdout
    assert "Do nothing for some ``minutes``: nothing is computed." in top
    assert top.index("Tasks and data") < top.index("Extensions") < top.index(" nap ")
    assert "imported" not in top
    assert "Do nothing for some ``minutes``" in ran("data", "--help").stdout
    assert ran("nap").stdout == "imported\nslept for 10\n"
    assert ran("data", "nap", "--minutes", "3").stdout == "imported\nslept for 3\n"
    wrong = ran("score", "--help")
    assert (wrong.returncode, wrong.stderr) == (
        2,
        "eai: rename the entry point score nap in eai.commands: "
        "score is a command and can have no subcommand\n",
    )


def test_there_are_few_commands() -> None:
    """The core has 13 at the top and 22 in all; one more has to take the place of one."""
    points = get_entry_points("eai.commands").values()
    of_extensions = tuple(point.name for point in points if point.module.startswith("eai.extensions."))
    top = [*get_command(app).commands]  # type: ignore[attr-defined]
    below = [name for name in commands(get_command(app)) if " " in name]
    of_core = [name for name in (*top, *below) if not name.startswith(of_extensions or "none")]
    assert len([name for name in of_core if " " not in name]) <= 13
    assert len(of_core) <= 22


def test_a_command_that_there_is_not_is_told_with_its_neighbours(eai: Command) -> None:
    status, _, told = eai("scores", "answers.json")
    assert (status, "'score'" in told) == (2, True)


@pytest.mark.parametrize("option", ["--version", "-V"])
def test_the_version_is_printed(eai: Command, option: str) -> None:
    assert eai(option)[:2] == (0, f"eai {__version__}\n")


@pytest.mark.parametrize("arguments", [("-h",), ("score", "-h"), ("data", "stats", "-h")])
def test_help_is_short_for_help(eai: Command, arguments: tuple[str, ...]) -> None:
    assert eai(*arguments) == eai(*arguments[:-1], "--help")


@pytest.mark.parametrize("columns", ["60", "80", "150"])
@pytest.mark.parametrize("command", ["run", "score", "report"])
def test_help_cuts_no_name_of_an_option(
    command: str, columns: str, eai: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    shown = eai(command, "--help").out
    assert shown
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= int(columns)


def commands(group: Any, *path: str) -> Iterator[str]:
    """The names of all commands below a group."""
    for name in list(group.commands):
        command = group.commands[name]
        if hasattr(command, "commands"):
            yield from commands(command, *path, name)
        else:
            yield " ".join((*path, name))


def test_help_has_an_example_and_names_values_as_the_field_does(
    eai: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    found = list(commands(get_command(app)))
    assert {"score", "analyze", "data fetch"} <= {*found}
    for command in found:
        shown = eai(*command.split(), "--help").out
        assert max(map(len, shown.splitlines())) <= 80, command
        assert "…" not in shown, command
        _, *examples = " ".join(shown.split()).split("Example: ")
        assert any(f"eai {command.removesuffix(' write')}" in example for example in examples), command
        of_python = r"<(?:list|bool|str|int|float|path|\w+ range)\b.*>|\b(?:TEXT|INTEGER|FLOAT)\b"
        assert not re.findall(of_python, shown), command


def test_a_run_without_inspect_is_refused_at_once_in_one_line() -> None:
    script = (
        "import sys\n"
        "from importlib import util\n"
        "find = util.find_spec\n"
        "util.find_spec = lambda name, package=None: None if name == 'inspect_ai' else find(name, package)\n"
        "from eai import cli\n"
        "sys.argv = ['eai', 'run', '--model', 'eai/noisy', '--data', '/nowhere']\n"
        "cli.main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "pip install 'eai-bench[run]'" in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_that_cannot_be_written_is_told_in_a_line(unbuffered: str) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "eai", "check", "--schema"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
        )
    assert (done.returncode, done.stderr) == (
        2,
        "eai: the output cannot be written (No space left on device)\n",
    )
