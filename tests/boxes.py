"""Boxes for tests: processes with this machine's files and separate users and network, like a container."""

from __future__ import annotations

import io
import os
import shlex
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import eai

SOURCE = Path(eai.__file__).parent.parent
NEEDED = ("unshare", "nsenter", "setpriv", "chroot", "mount", "ip", "useradd")

SETUP = """
set -e
mount -t tmpfs tmpfs "$1"; cd "$1"; mkdir upper work root
mount -t overlay overlay -o lowerdir=/,upperdir=upper,workdir=work root
mount -t proc proc root/proc; mount --rbind /dev root/dev; mount -t tmpfs -o mode=1777 tmpfs root/tmp
ip link set lo up
for part in $3; do
  case $part in /tmp/*) mkdir -p "root$part"; mount --bind "$part" "root$part";; esac
done
for part in $2; do chmod a+x "root$part"; done
echo ready
exec sleep infinity
"""


def lacking() -> str | None:
    """Return why a box cannot be made here, or None if it can."""
    if os.geteuid() != 0 or any(shutil.which(tool) is None for tool in NEEDED):
        return "it takes root and Linux"
    mount = ["unshare", "--mount", "--net", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    tried = subprocess.run(mount, capture_output=True, check=False)
    return "it takes mounts of one's own" if tried.returncode else None


class Box:
    """A separate root over all files of this machine. Files written in the box are lost with it.

    Args:
        folder: An empty folder.
        beside: Another box whose network it shares.
    """

    def __init__(self, folder: Path, beside: Box | None = None) -> None:
        folder.mkdir(parents=True)
        self.folder, self.cwd, self.env = folder, "/", dict[str, str]()
        self.started: list[subprocess.Popen[bytes]] = []
        used = [Path(sys.executable).resolve(), Path(sys.executable), SOURCE]
        above = sorted({str(part) for path in used for part in path.parents} - {"/"})
        installed = " ".join(map(str, [sys.prefix, sys.base_prefix, SOURCE]))
        network = ["unshare", "--net"] if beside is None else ["nsenter", "--target", beside.pid, "--net"]
        self.holder = subprocess.Popen(
            [
                *network,
                *("unshare", "--mount", "sh", "-c", SETUP, "sh", str(folder), " ".join(above), installed),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.holder.stdout is not None
        assert self.holder.stdout.readline() == "ready\n"

    @property
    def pid(self) -> str:
        return str(self.holder.pid)

    def command(self, script: str, user: str = "root", env: Mapping[str, str] | None = None) -> list[str]:
        """Return the command line that runs a script in the box."""
        path = f"{Path(sys.executable).parent}:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin"
        given = {"PATH": path, "PYTHONPATH": str(SOURCE), "HOME": "/", **self.env, **(env or {})}
        return [
            *("nsenter", "--target", self.pid, "--mount", "--net", "chroot", str(self.folder / "root")),
            *("setpriv", "--reuid", user, "--regid", user, "--clear-groups"),
            *("env", "-i", *[f"{name}={value}" for name, value in given.items()]),
            *("sh", "-c", f"cd {shlex.quote(self.cwd)} && {script}"),
        ]

    def run(self, script: str, user: str = "root", *, fails: bool = False, **more: Any) -> str:
        """Run a script in the box, and return its output."""
        done = subprocess.run(
            self.command(script, user, more.pop("env", None)),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            **more,
        )
        told: str = done.stdout.decode(errors="replace")
        assert fails or done.returncode == 0, told
        return told

    def start(self, command: Sequence[str], user: str) -> subprocess.Popen[bytes]:
        """Start a process in the box; it ends with the box."""
        started = subprocess.Popen(self.command(f"exec {shlex.join(command)}", user))
        self.started.append(started)
        return started

    def upload(self, path: Path, place: str) -> None:
        """Copy a file, or the content of a folder, into the box as root."""
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w") as tar:
            tar.add(path, "." if path.is_dir() else path.name)
        folder = place if path.is_dir() else str(Path(place).parent)
        self.run(
            f"mkdir -p {folder} && tar -x --no-same-owner --no-overwrite-dir -C {folder}",
            input=packed.getvalue(),
        )
        if not path.is_dir() and path.name != Path(place).name:
            self.run(f"mv {folder}/{path.name} {place}")

    def download(self, place: str, to: Path) -> None:
        """Copy a file or a folder from the box to a path below a folder."""
        command = self.command(f"tar -c -C / {place.removeprefix('/')}")
        packed = subprocess.run(command, capture_output=True, check=True).stdout
        with tarfile.open(fileobj=io.BytesIO(packed)) as tar:
            tar.extractall(to, filter="tar")

    def build(self, folder: Path, data: Path | None = None, *, again: bool = False) -> None:
        """Follow the steps of a Dockerfile, but copy data and install no packages: this machine has them.

        The check that benchmarks can be opened is left out.
        """
        for line in (folder / "Dockerfile").read_text().splitlines():
            word, _, rest = line.partition(" ")
            match word:
                case "RUN" if rest.startswith("pip install"):
                    if data is not None:
                        self.upload(data, "/data")
                case "RUN" if not (again and rest.startswith("python")):
                    self.run(rest)
                case "COPY":
                    source, place = rest.split()
                    self.upload(folder / source, place)
                case "WORKDIR":
                    self.run(f"mkdir -p {rest}")
                    self.cwd = rest
                case "ENV":
                    name, _, value = rest.partition("=")
                    self.env[name] = value
                case "FROM" | "#" | "" | "RUN":
                    pass
                case _:
                    raise AssertionError(line)

    def close(self) -> None:
        """Delete the box."""
        for process in self.started:
            process.kill()
            process.wait()
        self.holder.kill()
        self.holder.wait()
        assert self.holder.stdout is not None
        self.holder.stdout.close()
