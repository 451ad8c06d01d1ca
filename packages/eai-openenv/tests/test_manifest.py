"""Tests of the package and a running server with OpenEnv's own validator, and of the typed client."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from test_server import WON, address  # noqa: F401 - a fixture

from eai_openenv import HouseholdAction
from eai_openenv.client import HouseholdClient

PACKAGE = Path(__file__).parents[1]


def validated(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "openenv.cli", "validate", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


def test_openenv_accepts_the_manifest() -> None:
    done = validated("--level", "static", PACKAGE)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "PASS  static.manifest" in done.stdout


def test_openenv_accepts_a_running_server(address: str) -> None:  # noqa: F811
    done = validated("--url", f"http://{address}")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAIL" not in done.stdout


@pytest.fixture
def client(address: str) -> Iterator[HouseholdClient]:  # noqa: F811
    with HouseholdClient(base_url=f"http://{address}").sync() as opened:
        yield opened


def test_the_client_plays_an_episode(client: HouseholdClient) -> None:
    result = client.reset(seed=1)
    for command in WON:
        assert not result.done
        result = client.step(HouseholdAction(command=command))
    assert (result.done, client.state().over) == (True, True)
    assert result.observation.text


def test_the_application_of_the_manifest_serves_what_a_variable_names(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("EAI_DOMAINS", "lamps:lamps")
    module = import_module("eai_openenv.app")
    assert "/reset" in module.app.openapi()["paths"]
    with pytest.raises(AttributeError):
        module.other  # noqa: B018
