from __future__ import annotations

import json
import socket
from pathlib import Path

import pytest

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")

from command_line import Command
from eai.cli.serve import _write_access_tickets


def test_a_port_that_is_taken_is_told(eai: Command, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = eai(
            "serve", "mcp", "--domain", "agents.switches:SWITCHES", "--out", tmp_path / "out", "--port", port
        )
    told = f"eai: --port {port}: cannot listen there, at 127.0.0.1 (Address already in use)"
    assert (done.status, done.err.strip(), [*tmp_path.iterdir()]) == (2, told, [])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("", "eai: --tasks: expected one task, found 4; to serve several tasks, give --port and --tickets"),
        (
            "--port 1 --trust-network",
            "eai: --tasks: expected one task, found 4; to serve several tasks, give --port and --tickets",
        ),
        ("--tasks moon", "eai: --tasks: 'moon' is not a task of switches acting"),
        (
            "--port 1 --host 0.0.0.0",
            "eai: --host 0.0.0.0: also give --allow-host NAME, a host name that requests may use",
        ),
        (
            "--with harness=text",
            "eai: --with harness: this option is only for models that eai run asks; leave it out",
        ),
        ("--tasks both --with view=moon", "eai: agent.view: expected 'task' or 'scene', found 'moon'"),
    ],
)
def test_what_cannot_be_served_is_told(eai: Command, tmp_path: Path, words: str, told: str) -> None:
    out = tmp_path / "served"
    done = eai("serve", "mcp", "--domain", "agents.switches:SWITCHES", "--out", out, *words.split())
    assert (done.status, done.out) == (2, "")
    assert done.err.strip() == told
    assert not out.exists()


def test_tickets_are_hidden_even_in_a_file_that_all_could_read(tmp_path: Path) -> None:
    file = tmp_path / "tickets.json"
    file.write_text("[]", encoding="utf-8")
    file.chmod(0o644)
    assert _write_access_tickets(tmp_path, {"secret": ("27_2", 1)}) == file
    assert file.stat().st_mode & 0o777 == 0o600
    assert json.loads(file.read_text(encoding="utf-8"))[0]["ticket"] == "secret"
