"""Every command of README and docs, run as written: in a fresh home, with a fresh install.

    python tools/walk_docs.py --python python3.12 --installer uv --log walk.log README.md docs/running.md

Commands to hosted models go to a server on this machine that always answers ``{}``, so that they run as
written and cost nothing. What the pages speak of as being there (answers, runs, tasks) is made first. The
exit status is 1 if a command fails; the log has a line for each: status, seconds, page, command.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TextIO

ROOT = Path(__file__).parent.parent
EXTRAS = "run,plots,analysis,planner,envs"
FENCE = re.compile(r"^```(?P<language>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
PROGRAMS = ("eai", "inspect", "lm_eval", "for")
SKIPPED = {
    "pip install": "the walk installs from the checkout",
    "make": "continuous integration runs it",
    "docker": "there may be no daemon",
    "python tools/": "belongs to the checkout",
    "lm_eval": "another harness, with an environment of its own",
    "cd examples": "the walk puts the example into the folder",
}
SECONDS = 900

PRELUDE = r"""
eai run --model eai/noisy -M seed=1 --domain behavior --ability action_sequencing --out made/a
eai run --model eai/noisy -M seed=1 --domain behavior --ability goal_interpretation --out made/a
eai run --model eai/noisy -M seed=1 --domain behavior --ability subgoal_decomposition --out made/a
eai run --model eai/noisy -M seed=2 --domain behavior --ability action_sequencing --out made/b
eai run --model eai/noisy --domain virtualhome --ability action_sequencing --out made/v
eai generate --like behavior --n 5 --seed 1 --out tasks
"""
"""Makes what the commands speak of."""

RATINGS = """\
task,rater,attribute,score
27_2,one,clear,5
27_2,two,clear,4
11_1,one,clear,3
11_1,two,clear,3
"""
"""What people may say of tasks."""


class Silent(BaseHTTPRequestHandler):
    """A model that has nothing to say."""

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        message = {"role": "assistant", "content": "{}"}
        usage = {"prompt_tokens": 1, "completion_tokens": 1, "total_tokens": 2}
        choice = {"index": 0, "message": message, "finish_reason": "stop"}
        answer = {"id": "0", "object": "chat.completion", "created": 0, "model": "silent", "usage": usage}
        content = json.dumps({**answer, "choices": [choice]}).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        pass


@dataclass(frozen=True)
class Walk:
    """Where commands run, and where it is written down what became of them."""

    environment: dict[str, str]
    log: TextIO

    def run(self, command: str, folder: Path, page: str) -> bool:
        skipped = next((why for start, why in SKIPPED.items() if command.startswith(start)), None)
        if skipped is not None:
            self.tell(f"skipped  ({skipped})  {page}: {command}")
            return True
        start = time.monotonic()
        try:
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=SECONDS,
            )
            status, said = str(done.returncode), done.stderr or done.stdout
        except subprocess.TimeoutExpired:
            status, said = "timeout", ""
        self.tell(f"{status:>7}  {time.monotonic() - start:6.1f} s  {page}: {command}")
        if status != "0":
            self.tell("".join(f"         | {line}\n" for line in said.strip().splitlines()[-4:]).rstrip())
        return status == "0"

    def tell(self, text: str) -> None:
        print(text, flush=True)
        print(text, file=self.log, flush=True)


def commands(page: str) -> Iterator[str]:
    """The commands on a page, in order; one that goes on on the next line is one."""
    for block in FENCE.finditer(page):
        text = block["text"].replace("\\\n", " ")
        if block["language"] == "console":
            yield from (line[2:] for line in text.splitlines() if line.startswith("$ "))
        elif block["language"] in ("sh", "") and text.lstrip().startswith((*PROGRAMS, "pip")):
            if text.startswith("for "):
                yield text
            else:
                yield from (line for line in text.splitlines() if line.strip() and not line.startswith("#"))


def install(python: str, installer: str, place: Path) -> Path:
    """Install the checkout with its extras into an environment; the folder of its programs."""
    target = f"{ROOT}[{EXTRAS}]"
    subprocess.run([python, "-m", "venv", place], check=True)
    programs = place / "bin"
    if installer == "uv":
        subprocess.run(
            ["uv", "pip", "install", "--quiet", "--python", programs / "python", target], check=True
        )
    else:
        subprocess.run([programs / "python", "-m", "pip", "install", "--quiet", target], check=True)
    return programs


def prepare(walk: Walk, ground: Path) -> None:
    """What pages take for granted: answers, runs, tasks, the example of a domain."""
    for command in PRELUDE.replace("\\\n", " ").strip().splitlines():
        if not walk.run(command, ground, "(prelude)"):
            raise SystemExit("the prelude failed")
    answers = {
        ability: ground / f"made/a/behavior/{ability}/eai_noisy/eai_noisy_outputs.json"
        for ability in ("action_sequencing", "goal_interpretation", "subgoal_decomposition")
    }
    virtualhome = ground / "made/v/virtualhome/action_sequencing/eai_noisy/eai_noisy_outputs.json"
    copies = {
        "mine_outputs.json": virtualhome,
        "person-1_outputs.json": virtualhome,
        "gpt-4o_outputs.json": answers["goal_interpretation"],
        "answers/goals/gpt-4o_outputs.json": answers["goal_interpretation"],
        "answers/pipeline/gpt-4o_outputs.json": answers["subgoal_decomposition"],
        "answers/behavior/action_sequencing/gpt-4o_outputs.json": answers["action_sequencing"],
        "answers/virtualhome/action_sequencing/gpt-4o_outputs.json": virtualhome,
    }
    for name, source in copies.items():
        (ground / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, ground / name)
    (ground / "ratings.csv").write_text(RATINGS, encoding="utf-8")
    shutil.copytree(ROOT / "examples/lamps", ground, dirs_exist_ok=True)
    (ground / "problems").mkdir()
    for file in (ROOT / "tests/pddl/domains/gripper").iterdir():
        shutil.copy(file, ground if file.name == "domain.pddl" else ground / "problems")
    walk.run("eai submission build made/a --out submission.zip || true", ground, "(prelude)")
    shutil.rmtree(ground / "made")


def walk_through(pages: Sequence[Path], walk: Walk, work: Path) -> int:
    """Run the commands of the pages, those of each in a folder of its own; how many fail."""
    ground = work / "ground"
    ground.mkdir()
    prepare(walk, ground)
    failed = 0
    for page in pages:
        folder = work / page.stem
        shutil.copytree(ground, folder)
        name = page.relative_to(ROOT).as_posix()
        for command in commands(page.read_text("utf-8")):
            if command.startswith("cd ") and (folder / command[3:]).is_dir():
                folder /= command[3:]
            else:
                failed += not walk.run(command, folder, name)
    return failed


def main() -> int:
    every = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="*", type=Path, help="pages; README and docs/*.md if none is given")
    parser.add_argument("--python", default=sys.executable, help="the Python to install for")
    parser.add_argument("--installer", choices=("pip", "uv"), default="pip")
    parser.add_argument("--log", type=Path, default=Path("walk.log"))
    options = parser.parse_args()
    server = ThreadingHTTPServer(("127.0.0.1", 0), Silent)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as place, options.log.open("a", encoding="utf-8") as log:
        work = Path(place)
        programs = install(options.python, options.installer, work / "venv")
        (work / "home").mkdir()
        kept = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("EAI_", "PYTHON", "VIRTUAL_ENV"))
        }
        settings = Path.home() / ".config/pip/pip.conf"  # where packages come from is the machine's to say
        kept |= {"PIP_CONFIG_FILE": str(settings)} if settings.exists() else {}
        environment = {
            **kept,
            "HOME": str(work / "home"),
            "PATH": f"{programs}:{os.environ['PATH']}",
            "OPENAI_BASE_URL": f"http://127.0.0.1:{server.server_address[1]}/v1",
            "OPENAI_API_KEY": "none",
            "SLURM_ARRAY_TASK_ID": "1",
            "COLUMNS": "80",
        }
        walk = Walk(environment, log)
        walk.tell(f"# {options.python}, {options.installer}")
        failed = walk_through([page.resolve() for page in options.pages] or every, walk, work)
        walk.tell(f"# {failed} failed")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
