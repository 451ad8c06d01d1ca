"""What an agent may try from its box beside the world, instead of acting."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from boxes import lacking
from by_path import ROOT
from eai.base.store import DataPackStore
from eai.extensions.harbor.folders import IMAGE
from extensions.harbor.trials import Trial, exported

WHY_NOT = lacking()
pytestmark = pytest.mark.skipif(WHY_NOT is not None, reason=f"a trial runs in boxes: {WHY_NOT}")

LAMPS = ROOT / "examples/lamps/lamps.py"
TASK = {
    "id": "dark",
    "base": "lamps:lamps",
    "instruction": "Light up.",
    "objects": {"robot": "robot", "lamp": "lamp"},
    "agent": "robot",
    "facts": {},
    "goals": ["lit(lamp)"],
    "plan": [["GO", "lamp"], ["PRESS", "lamp"]],
}

JUNK = """
import socket, urllib.request

def post(body, **headers):
    headers = {"Content-Type": "application/json", "Accept": "application/json, text/event-stream", **headers}
    try:
        urllib.request.urlopen(urllib.request.Request("http://world:8000/mcp", body, headers), timeout=20)
        print("let in", body[:30])
    except OSError as error:
        print("refused", error)

call = b'{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"done","arguments":{}}}'
for body in (b"", b"{", b"[" * 60_000, b"A" * 5_000_000, b"\\0" * 4_000, b"\\xff\\xfe", b'{"a":' * 9_000):
    post(body)
post(call, Host="evil.example")
post(call, Origin="http://evil.example")
with socket.create_connection(("world", 8000)) as broken:
    broken.send(b"POST /mcp HTTP/1.1\\r\\nHost: world\\r\\nContent-Length: 99999999\\r\\n\\r\\nabc")
"""


@pytest.fixture
def trial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Trial]:
    monkeypatch.syspath_prepend(LAMPS.parent)
    (tmp_path / "nights.jsonl").write_text(json.dumps(TASK) + "\n")
    (folder,) = exported(str(tmp_path / "nights.jsonl"), "acting", ["dark"], tmp_path / "out")
    shutil.copy(LAMPS, tmp_path / "out" / IMAGE)
    (tmp_path / "none").mkdir()
    with Trial(folder, tmp_path / "trial", DataPackStore(tmp_path / "none")) as trial:
        yield trial


def test_nothing_but_acting_wins(trial: Trial) -> None:
    pid = trial.world.pid
    secrets = ["environ", "mem", "fd", "cwd/", "root/journal/key", "root/tests/nights.jsonl"]
    for place in ["/journal", "/tests", "/solution", *[f"/proc/{pid}/{name}" for name in secrets]]:
        told = trial.agent(f"ls {place} && head -c 9 {place}")
        assert "denied" in told or "No such file" in told, (place, told)
    for what in (
        f"kill -9 {pid}",
        f"kill -USR1 {pid}",
        "mkdir -p /logs/verifier",
        "touch /usr/local/bin/act",
    ):
        told = trial.agent(what)
        assert "not permitted" in told or "denied" in told, told
    told = trial.agent("python -", input=JUNK.encode())
    assert told.count("refused") == 9, told
    assert "let in" not in told
    trial.solve()
    assert trial.judge()["reward"] == 1


def test_the_journal_outlives_calls_at_once_and_the_end_of_its_world(trial: Trial) -> None:
    trial.agent("for i in 1 2 3 4 5 6 7; do act 'GO(lamp)' & done; wait")
    trial.world.kill()
    trial.world.wait()
    trial.boxes["world"].run("for file in /journal/episodes/1/*; do printf 'abc {\"act' >> $file; done")
    trial.start_world()
    trial.agent("act 'PRESS(lamp)'; act done")
    assert trial.judge() == {"reward": 1, "success": 1, "within_2x": 0, "spl": 0.25, "valid": 1}
