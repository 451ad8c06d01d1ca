"""Task folders for Harbor: one a task, and a folder from which the image with their worlds is built."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from string import Template
from typing import TypeAlias

from eai import __version__
from eai.abilities.declaration import declaration_of
from eai.agents.command import DONE
from eai.base.errors import InputError
from eai.base.files import files_below, read_content, write_whole
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.names import TaskReference
from eai.benchmarks.registry import PDDL, list_benchmarks
from eai.benchmarks.suite import Suite
from eai.extensions.harbor.verify import is_right
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.task_files import lines_in

_Files: TypeAlias = dict[str, str | bytes]
"""The contents of files by their places in a folder."""

IMAGE = "image"
"""The folder, beside those of tasks, from which the image with their worlds is built."""

_PACKAGE = "eai-bench"

_EXECUTABLE = frozenset({"act", "solve.sh", "test.sh"})

_NO_NAME = re.compile(r"[^A-Za-z0-9_.-]+")
"""The characters that the name of a task folder does not have."""

NO_SOLUTION = "without a solution that is known to be right"
FREE = "in which doing nothing, or copying the question, is right"
"""Why a task has no folder."""

_EMPTY_ANSWERS = ("", "[]", "{}", DONE)
"""Answers of an agent that does nothing: empty texts, plans and episodes."""


def _written(answer: str) -> str:
    return f"cat > /workdir/answer.txt <<'END_OF_ANSWER'\n{answer}\nEND_OF_ANSWER"


def _acted(answer: str) -> str:
    return "\n".join([f"act {quote(command)}" for command in answer.splitlines()])


def write_task_folders(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    out: Path,
    *,
    wheels: Sequence[Path] = (),
    image: str | None = None,
    verifier_image: str | None = None,
    is_shared: bool = False,
) -> tuple[int, Counter[str]]:
    """Write a folder for each task that has a prompt, and `IMAGE`; counts the tasks, and those left out.

    Args:
        suite: the tasks.
        prompts: what is asked.
        out: the folder, which is new or empty.
        wheels: the files from which eai, and what else a benchmark needs, is installed; an index if none.
        image: the image of the agent's box; None if it is built from the folder of the task.
        verifier_image: the image with the worlds; None if it is built from `IMAGE`.
        is_shared: whether answers are scored in the agent's box.

    Raises:
        InputError: the folder is not empty or cannot be written, a wheel or a file of tasks cannot be read,
            the tasks cannot be asked in this way, or all are left out.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"{out}: expected a new or an empty folder")
    if is_shared and declaration_of(suite.ability).takes_turns:
        raise InputError(f"--shared: {suite.ability} is scored where the agent cannot write")
    contents: _Files = {wheel.name: read_content(wheel) for wheel in wheels}
    exporter = _Exporter(suite, contents, image, verifier_image, is_shared)
    gold = open_answer_book(suite.benchmark, suite.ability, suite.source)
    chosen: dict[str, str] = {}
    left_out = Counter[str]()
    for task_id, prompt in prompts.items():
        solution = gold[task_id].text
        reason = _reason(suite, task_id, prompt, solution)
        if reason is not None:
            left_out[reason] += 1
            continue
        slug = _NO_NAME.sub("-", f"{suite.domain}-{suite.ability}-{task_id}")
        if slug in chosen:
            raise InputError(f"the tasks {chosen[slug]} and {task_id} have the same name of a folder, {slug}")
        chosen[slug] = task_id
        _write(out / slug, exporter.task_folder(slug, task_id, prompt, solution))
    if not chosen:
        raise InputError(f"{suite.domain} {suite.ability}: there is no task that is not left out")
    if not is_shared:
        _write(out / IMAGE, exporter.image_folder(chosen.values()))
    return len(chosen), left_out


def _reason(suite: Suite, task_id: str, prompt: Prompt, solution: str) -> str | None:
    """Why a task is left out, if it is.

    Raises:
        InputError: its question has pictures.
    """
    if prompt.images:
        raise InputError(f"{suite.domain} {suite.ability}: Harbor's instructions have no pictures")
    if not is_right(suite, suite.score(task_id, solution)):
        return NO_SOLUTION
    free = any(is_right(suite, suite.score(task_id, text)) for text in (*_EMPTY_ANSWERS, prompt.user))
    return FREE if free else None


@dataclass(frozen=True, slots=True)
class _Exporter:
    """The contents of folders; the fields are the arguments of `write_task_folders`."""

    suite: Suite
    wheels: _Files
    image: str | None
    verifier_image: str | None
    is_shared: bool

    @property
    def acts(self) -> bool:
        """Whether answers are episodes, in a world of their own."""
        return declaration_of(self.suite.ability).takes_turns

    def task_folder(self, slug: str, task_id: str, prompt: Prompt, solution: str) -> _Files:
        """The files of a task, by their places."""
        reference, tasks = _carried(self.suite.benchmark.reference, [task_id])
        about = {
            **self._about(reference),
            "slug": slug,
            "task_id": json.dumps(task_id),
            "task": json.dumps(str(TaskReference(reference, self.suite.ability, task_id))),
            "question": "\n\n".join(filter(None, [prompt.system, prompt.user])),
            "solution": _acted(solution) if self.acts else _written(solution),
            "world": _world(reference, task_id) if self.acts else "",
        }
        tests = _filled(["script"], about) | (self.wheels | tasks if self.is_shared else {})
        groups = ["every", "acting" if self.acts else "answer", *([] if self.is_shared else ["separate"])]
        return _filled(groups, about) | {f"tests/{name}": content for name, content in tests.items()}

    def image_folder(self, task_ids: Collection[str]) -> _Files:
        """The files from which the image with the worlds of tasks is built."""
        reference, tasks = _carried(self.suite.benchmark.reference, task_ids)
        return _filled(["image", "script"], self._about(reference)) | self.wheels | tasks

    def _about(self, reference: str) -> dict[str, str]:
        """The values of the places in templates that all folders share."""
        extra = "[mcp]" if self.acts else ""
        found = [f"./{wheel}{extra}" for wheel in self.wheels] or [f"{_PACKAGE}{extra}=={__version__}"]
        mode = "shared" if self.is_shared else "separate"
        own = f'\n\n[verifier.environment]\nnetwork_mode = "no-network"{_image_line(self.verifier_image)}'
        return {
            "ability": json.dumps(self.suite.ability.value),
            "agent_image": _image_line(self.image),
            "benchmark": json.dumps(reference),
            "requirements": " ".join(map(quote, found)),
            "verifier": f'environment_mode = "{mode}"{"" if self.is_shared else own}',
            "verifier_image": self.verifier_image or f"eai-worlds:{__version__}",
            "version": __version__,
        }


def _image_line(image: str | None) -> str:
    return "" if image is None else f"\ndocker_image = {json.dumps(image)}"


def _world(reference: str, task_id: str) -> str:
    """The command of the world of a task, as a list in Compose's YAML, where a dollar sign is doubled.

    Raises:
        InputError: commands cannot name the task.
    """
    if "," in task_id:
        raise InputError(f"the task {task_id!r}: expected an id without a comma, for eai serve mcp --tasks")
    where = ("--out=/journal", "--host=0.0.0.0", "--port=8000", "--allow-host=world", "--trust-network")
    command = ["eai", "serve", "mcp", f"--domain={reference}", f"--tasks={task_id}", *where]
    return json.dumps(command).replace("$", "$$")


def _carried(reference: str, task_ids: Collection[str]) -> tuple[str, _Files]:
    """The reference of a benchmark where its files are beside, and those files: with these tasks alone."""
    kind, _, named = reference.partition(":")
    if kind == PDDL:
        if "," not in named:
            folder = Path(named).resolve()
            inside = files_below(folder, "*.pddl")
            contents: _Files = {
                part.relative_to(folder.parent).as_posix(): read_content(part) for part in inside
            }
            return f"{PDDL}:{folder.name}", contents
        domain, problems = map(Path, named.split(",", 1))
        parts = [problems] if problems.is_file() else files_below(problems, "*.pddl")
        beside = {part.relative_to(problems.parent).as_posix(): read_content(part) for part in parts}
        return f"{PDDL}:{domain.name},{problems.name}", {domain.name: read_content(domain), **beside}
    path = Path(reference)
    if reference in list_benchmarks() or not path.exists():
        return reference, {}
    name = f"{path.resolve().name.partition('.')[0]}.jsonl"
    kept = [place.content for place in lines_in(path) if json.loads(place.content)["id"] in task_ids]
    return name, {name: b"\n".join(kept) + b"\n"}


def _filled(groups: Sequence[str], values: Mapping[str, str]) -> _Files:
    """The files of groups of templates, by their places in a folder."""
    return {
        file.relative_to(folder).as_posix(): Template(file.read_text("utf-8")).substitute(values)
        for folder in [Path(__file__).parent / "templates" / group for group in groups]
        for file in files_below(folder, "*")
    }


def _write(folder: Path, contents: _Files) -> None:
    write_whole({folder / name: content for name, content in contents.items()})
    for name in contents:
        if Path(name).name in _EXECUTABLE:
            (folder / name).chmod(0o755)
