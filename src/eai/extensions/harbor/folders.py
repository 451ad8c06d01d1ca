"""Write task folders for Harbor, and the folder for building the container image with the tasks' worlds."""

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
from eai.abilities.declaration import get_declaration
from eai.agents.command import DONE
from eai.base.entry_points import get_entry_points
from eai.base.errors import InputError
from eai.base.files import find_files_below, format_toml_text, read_content, write_files_atomically
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.names import TaskReference
from eai.benchmarks.registry import OPENERS, PDDL, list_benchmarks
from eai.benchmarks.suite import Suite
from eai.extensions.harbor.verify import is_right_answer
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.task_files import read_task_file_lines

_Files: TypeAlias = dict[str, str | bytes]
"""Contents of files by their paths relative to a folder."""

IMAGE = "image"
"""Name of the folder, beside the task folders, from which the container image of the worlds is built."""

_PACKAGE = "eai-bench"

_EXECUTABLE = frozenset({"act", "solve.sh", "test.sh"})

_PROMPT_VARIANT_PREFIXES = ("obfuscated", "rules")
"""Prefixes of references to a benchmark with other words or other prompts, as in `obfuscated:virtualhome`."""

_INVALID_CHARACTERS = re.compile(r"[^A-Za-z0-9_.-]+")
"""Regular expression for characters that the name of a task folder may not contain."""

NO_SOLUTION = "without a verified solution"
"""Reason for leaving tasks out: the phrase that follows the number of left-out tasks in a message."""
SOLVED_WITHOUT_WORK = "in which doing nothing, or copying the question, is right"
"""Reason for leaving out tasks that need no work: the phrase that follows their number in a message."""

_EMPTY_ANSWERS = ("", "[]", "{}", DONE)
"""Answers of an agent that does nothing: empty texts, plans and episodes."""


def _make_shell_command_to_write_answer(answer: str) -> str:
    return f"cat > /workdir/answer.txt <<'END_OF_ANSWER'\n{answer}\nEND_OF_ANSWER"


def _convert_episode_commands_to_shell_commands(episode_commands: str) -> str:
    return "\n".join([f"act {quote(command)}" for command in episode_commands.splitlines()])


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
    """Write a folder for each task with a prompt, and the folder `IMAGE`.

    Args:
        suite: The tasks.
        prompts: The prompt of each task, by task id.
        out: A new or empty folder.
        wheels: Package files (wheels) from which eai and the package of a benchmark are installed; if empty,
            both are installed from a package index.
        image: Image of the agent's container; None if it is built from the folder of the task.
        verifier_image: Image of the container that simulates the tasks and scores answers; None if it is
            built from `IMAGE`.
        is_shared: Whether answers are scored in the agent's container.

    Returns:
        The number of tasks with a folder, and the number of left-out tasks for each reason.

    Raises:
        InputError: The folder is not empty or cannot be written, a wheel or a file of tasks cannot be read,
            the tasks cannot be written as folders, or all tasks are left out.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"{out}: expected a new or an empty folder")
    if is_shared and get_declaration(suite.ability).takes_turns:
        raise InputError(
            f"--shared: {suite.ability} must be scored in a container that the agent cannot write to; "
            "omit this option"
        )
    contents: _Files = {wheel.name: read_content(wheel) for wheel in wheels}
    exporter = _HarborFolderMaker(suite, contents, image, verifier_image, is_shared)
    gold = open_gold_answers(suite.benchmark, suite.ability, suite.source)
    chosen: dict[str, str] = {}
    folders: dict[str, _Files] = {}
    left_out = Counter[str]()
    for task_id, prompt in prompts.items():
        solution = gold[task_id].text
        reason = _find_reason_to_leave_out(suite, task_id, prompt, solution)
        if reason is not None:
            left_out[reason] += 1
            continue
        slug = _INVALID_CHARACTERS.sub("-", f"{suite.domain}-{suite.ability}-{task_id}")
        if slug in chosen:
            raise InputError(
                f"the tasks {chosen[slug]} and {task_id} have the same folder name, {slug}: rename one"
            )
        chosen[slug] = task_id
        folders[slug] = exporter.make_task_files(slug, task_id, prompt, solution)
    if not chosen:
        reasons = ", ".join([f"{count} {reason}" for reason, count in left_out.items()])
        raise InputError(
            f"{suite.domain} {suite.ability}: all tasks are left out ({reasons}); choose other tasks"
        )
    if not is_shared:
        folders[IMAGE] = exporter.make_image_files(chosen.values())
    for name, files in folders.items():
        _write_files(out / name, files)
    return len(chosen), left_out


def _find_reason_to_leave_out(suite: Suite, task_id: str, prompt: Prompt, solution: str) -> str | None:
    """Return why a task is not exported to a Harbor folder, or None if it is exported.

    Raises:
        InputError: The prompt has pictures.
    """
    if prompt.images:
        raise InputError(
            f"{suite.domain} {suite.ability}: prompts with pictures cannot be written for Harbor; "
            "choose prompts without pictures"
        )
    if not is_right_answer(suite, suite.score(task_id, solution)):
        return NO_SOLUTION
    free = any(is_right_answer(suite, suite.score(task_id, text)) for text in (*_EMPTY_ANSWERS, prompt.user))
    return SOLVED_WITHOUT_WORK if free else None


@dataclass(frozen=True, slots=True)
class _HarborFolderMaker:
    """Makes the contents of task folders. The fields hold the arguments of `write_task_folders`."""

    suite: Suite
    wheels: _Files
    image: str | None
    verifier_image: str | None
    is_shared: bool

    @property
    def are_answers_episodes(self) -> bool:
        """Whether answers are episodes (actions in a world that the verifier serves) and not texts."""
        return get_declaration(self.suite.ability).takes_turns

    def make_task_files(self, slug: str, task_id: str, prompt: Prompt, solution: str) -> _Files:
        """Return the files of a task: content by path relative to the task's folder."""
        reference, tasks = _bundle_benchmark(self.suite.benchmark.reference, [task_id])
        values = {
            **self._make_placeholder_values_for_all_folders(reference),
            "slug": slug,
            "task_id": format_toml_text(task_id),
            "task": format_toml_text(str(TaskReference(reference, self.suite.ability, task_id))),
            "question": "\n\n".join(filter(None, [prompt.system, prompt.user])),
            "solution": _convert_episode_commands_to_shell_commands(solution)
            if self.are_answers_episodes
            else _make_shell_command_to_write_answer(solution),
            "world": _write_world_server_command(reference, task_id) if self.are_answers_episodes else "",
        }
        tests = _fill_templates(["script"], values) | (self.wheels | tasks if self.is_shared else {})
        groups = [
            "every",
            "acting" if self.are_answers_episodes else "answer",
            *([] if self.is_shared else ["separate"]),
        ]
        return _fill_templates(groups, values) | {f"tests/{name}": content for name, content in tests.items()}

    def make_image_files(self, task_ids: Collection[str]) -> _Files:
        """Return the files of a container image with some tasks' worlds, by relative path."""
        reference, tasks = _bundle_benchmark(self.suite.benchmark.reference, task_ids)
        return (
            _fill_templates(["image", "script"], self._make_placeholder_values_for_all_folders(reference))
            | self.wheels
            | tasks
        )

    def _make_placeholder_values_for_all_folders(self, benchmark_reference: str) -> dict[str, str]:
        """Return the values of the placeholders that the templates of all task folders have in common."""
        extra = "[mcp]" if self.are_answers_episodes else ""
        requirements = [f"./{wheel}{extra}" for wheel in self.wheels] or [f"{_PACKAGE}{extra}=={__version__}"]
        mode = "shared" if self.is_shared else "separate"
        image = _write_docker_image_setting(self.verifier_image)
        own = f'\n\n[verifier.environment]\nnetwork_mode = "no-network"{image}'
        return {
            "ability": format_toml_text(self.suite.ability.value),
            "agent_image": _write_docker_image_setting(self.image),
            "benchmark": format_toml_text(benchmark_reference),
            "requirements": " ".join(map(quote, requirements)),
            "verifier": f'environment_mode = "{mode}"{"" if self.is_shared else own}',
            "verifier_image": self.verifier_image or f"eai-worlds:{__version__}",
            "version": __version__,
        }


def _write_docker_image_setting(image: str | None) -> str:
    return "" if image is None else f"\ndocker_image = {format_toml_text(image)}"


def _write_world_server_command(benchmark_reference: str, task_id: str) -> str:
    """Return the command that serves the world of a task, as a list in the YAML of Docker Compose.

    A dollar sign is written twice, because Compose replaces variables after a single dollar sign.

    Raises:
        InputError: The task's id contains a comma, which `--tasks` reads as a separator.
    """
    if "," in task_id:
        raise InputError(f"the task {task_id!r}: expected an id without a comma, for eai serve mcp --tasks")
    settings = ("--out=/journal", "--host=0.0.0.0", "--port=8000", "--allow-host=world", "--trust-network")
    command = ["eai", "serve", "mcp", f"--domain={benchmark_reference}", f"--tasks={task_id}", *settings]
    return json.dumps(command, ensure_ascii=False).replace("$", "$$")


def _bundle_benchmark(reference: str, task_ids: Collection[str]) -> tuple[str, _Files]:
    """Return the reference by which `eai` opens a benchmark beside copies of its files, and these copies.

    A copy of a task file has only the given tasks. PDDL files are copied whole. A registered benchmark keeps
    its name and needs no files.

    Raises:
        InputError: The files cannot be read or copied.
    """
    kind, _, location = reference.partition(":")
    if kind == PDDL:
        if "," not in location:
            folder = Path(location).resolve()
            files = find_files_below(folder, "*.pddl")
            contents: _Files = {
                file.relative_to(folder.parent).as_posix(): read_content(file) for file in files
            }
            return f"{PDDL}:{folder.name}", contents
        domain, problems = [Path(part.strip()) for part in location.split(",", 1)]
        files = [problems] if problems.is_file() else find_files_below(problems, "*.pddl")
        beside = {
            f"problems/{file.relative_to(problems.parent).as_posix()}": read_content(file) for file in files
        }
        reference = f"{PDDL}:{domain.name},problems/{problems.name}"
        return reference, {domain.name: read_content(domain), **beside}
    if kind in _PROMPT_VARIANT_PREFIXES:
        reference, contents = _bundle_benchmark(location, task_ids)
        return f"{kind}:{reference}", contents
    if kind != reference and kind in get_entry_points(OPENERS):
        raise InputError(
            f"{reference}: these files cannot be copied into the image; "
            "choose a benchmark's name, task files or files of PDDL"
        )
    path = Path(reference)
    if reference in list_benchmarks() or not path.exists():
        return reference, {}
    name = f"{path.resolve().name.partition('.')[0]}.jsonl"
    lines = [
        line.content for line in read_task_file_lines(path) if json.loads(line.content)["id"] in task_ids
    ]
    base = json.loads(lines[0]).get("base") if lines else None
    if base and _bundle_benchmark(base, ())[1]:
        raise InputError(f"{path}: its base {base} is in other files, which cannot be copied into the image")
    return name, {name: b"\n".join(lines) + b"\n"}


def _fill_templates(groups: Sequence[str], values: Mapping[str, str]) -> _Files:
    """Return the files of some groups of templates after filling in values.

    The result maps the path of a file, relative to its folder, to its content.
    """
    return {
        file.relative_to(folder).as_posix(): Template(file.read_text("utf-8")).substitute(values)
        for folder in [Path(__file__).parent / "templates" / group for group in groups]
        for file in find_files_below(folder, "*")
    }


def _write_files(folder: Path, contents: _Files) -> None:
    write_files_atomically({folder / name: content for name, content in contents.items()})
    for name in contents:
        if Path(name).name in _EXECUTABLE:
            (folder / name).chmod(0o755)
