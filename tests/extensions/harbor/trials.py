"""Trials of task folders in boxes of this machine: environment, agent, collection, verifier of its own."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import yaml  # type: ignore[import-untyped]

from boxes import Box
from eai.abilities.protocol import Ability
from eai.base.files import parse_toml
from eai.base.store import DataPackStore
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.harbor.folders import IMAGE, write_task_folders
from eai.tasks.prompts.prompt import Prompt

HARBOR = os.environ.get("EAI_HARBOR") or shutil.which("harbor")
"""The command of Harbor, which is installed in an environment of its own."""


def lint(folder: Path) -> list[dict[str, object]]:
    """What Harbor's own check finds, all rules applied but that of digests, as images are built here.

    The file of Compose is taken out where there is no Docker with Compose, by which Harbor reads it.
    """
    assert HARBOR is not None
    asked = ["docker", "compose", "version"]
    if shutil.which("docker") is None or subprocess.run(asked, capture_output=True, check=False).returncode:
        (folder / "environment/docker-compose.yaml").unlink(missing_ok=True)
    command = [HARBOR, "lint", "--select", "ALL", "--ignore", "unpinned-image", "--json", str(folder)]
    done = subprocess.run(command, capture_output=True, check=False)
    found: list[dict[str, object]] = json.loads(done.stdout)
    return found


def asked(domain: str, ability: str, task_ids: Sequence[str] = ()) -> tuple[Suite, dict[str, Prompt]]:
    """A suite, and the prompts of tasks; of all if none is named."""
    suite = open_suite(domain, Ability(ability))
    prompts = PromptLibrary("official", None, suite.source).open(suite.benchmark, suite.ability)
    return suite, {task_id: prompts[task_id] for task_id in task_ids or suite.task_ids}


def exported(domain: str, ability: str, task_ids: Sequence[str], out: Path, **how: Any) -> list[Path]:
    """The folders of tasks."""
    write_task_folders(*asked(domain, ability, task_ids), out, **how)
    return sorted(path for path in out.iterdir() if path.name != IMAGE)


class Trial:
    """The course of a trial, as Harbor's documentation has it.

    Args:
        folder: the task folder.
        place: an empty folder for what is kept of it.
        data: where the data set is.
    """

    def __init__(self, folder: Path, place: Path, data: DataPackStore) -> None:
        self.folder, self.place, self.data = folder, place, data
        self.about = parse_toml((folder / "task.toml").read_text())
        self.user = self.about["agent"]["user"]
        self.main = Box(place / "main")
        self.boxes = {"main": self.main}
        self.main.build(folder / "environment")
        self.services = self._services()
        if "world" in self.services:
            self.boxes["world"] = Box(place / "world", self.main)
            self.boxes["world"].build(folder.parent / IMAGE, data.folder)
            self.main.run("echo 127.0.0.1 world >> /etc/hosts")
            self.start_world()

    def _services(self) -> dict[str, dict[str, Any]]:
        path = self.folder / "environment/docker-compose.yaml"
        found: dict[str, dict[str, Any]] = (
            yaml.safe_load(path.read_text())["services"] if path.exists() else {}
        )
        return found

    def start_world(self) -> None:
        """Start the world as Compose does, and wait until it is healthy."""
        service, box = self.services["world"], self.boxes["world"]
        self.world = box.start(service["command"], service["user"])
        check = shlex.join(service["healthcheck"]["test"][1:])
        for _ in range(120):
            if box.run(f"{check} 2>/dev/null; echo $?") == "0\n":
                return
            assert self.world.poll() is None, "the world has ended"
            time.sleep(0.5)
        raise AssertionError("the world is not healthy")

    def agent(self, script: str, **more: Any) -> str:
        """What a script prints that the agent runs, whether it fails or not."""
        return self.main.run(script, self.user, fails=True, **more)

    def solve(self) -> None:
        self.main.upload(self.folder / "solution", "/solution")
        self.main.run("/solution/solve.sh", self.user)

    def collect(self) -> Path:
        """The artifacts, after the hooks."""
        kept = self.place / "artifacts"
        kept.mkdir(exist_ok=True)
        for hook in self.about["verifier"].get("collect", ()):
            service = self.services[hook["service"]]
            command = hook["command"].replace(" 1 ", f" {self.world.pid} ")  # which is 1 in a container
            self.boxes[hook["service"]].run(command, service["user"], fails=True)
        for artifact in self.about["artifacts"]:
            about = {"source": artifact} if isinstance(artifact, str) else artifact
            box, source = self.boxes[about.get("service", "main")], about["source"]
            if box.run(f"test -e {source}; echo $?") == "0\n":
                box.download(source, kept)
        return kept

    def judge(self, artifacts: Path | None = None) -> dict[str, float]:
        """The rewards, for the artifacts alone, or in the agent's box."""
        if self.about["verifier"]["environment_mode"] == "shared":
            box = self.main
        else:
            name = f"verifier-{len(self.boxes)}"
            box = self.boxes[name] = Box(self.place / name)
            box.build(self.folder.parent / IMAGE, self.data.folder, again=True)
            box.upload(artifacts or self.collect(), "/")
        box.upload(self.folder / "tests", "/tests")
        box.run("/tests/test.sh", env=self.about["verifier"]["env"])
        found: dict[str, float] = json.loads(box.run("cat /logs/verifier/reward.json"))
        return found

    def __enter__(self) -> Trial:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for box in self.boxes.values():
            box.close()
