"""The packs that several households read, made from the reference's wheel, and its identifiers of tasks.

Most keep files of the wheel byte for byte, under names of ours (`packs.toml`).
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Mapping
from functools import cache, partial
from importlib.resources import files
from pathlib import PurePosixPath

from eai.base.errors import DataError
from eai.base.files import parse_toml
from eai.base.source import Archive, Bundle
from eai.base.store import ReportProgress
from eai.benchmarks.packs import Pack

SCENE_PREFIX = "scene_1_"

_OTHER_SCENE = re.compile(r"scene_(?!1_)\d+_")
"""The prefix of identifiers of tasks in unpublished scenes, in the challenge's final phase."""

_MISNAMED = {
    "cleaning_up_after_a_meal_0_Merom_1_int_0_2021-06-06_19-55-27": (
        "cleaning_up_after_a_meal_0_Wainscott_0_int_0_2021-10-20_05-33-24"
    )
}
"""The shipped prompts of BEHAVIOR's goal interpretation call one task by the id of another demonstration."""


def task_id_of(identifier: str) -> str:
    """The data set's id of the task that an identifier in a file of answers or prompts means."""
    task_id = identifier.removeprefix(SCENE_PREFIX)
    return _MISNAMED.get(task_id, task_id)


def published_task(identifier: str) -> str | None:
    """The same, or None where the identifier is of a task that is known not to be in the data set."""
    return None if _OTHER_SCENE.match(identifier) else task_id_of(identifier)


@cache
def _tables() -> Mapping[str, Mapping[str, str]]:
    return parse_toml((files("eai.benchmarks") / "packs.toml").read_text(encoding="utf-8"))


def files_of(pack: str) -> Mapping[str, str]:
    """The files of the wheel that a pack consists of, by member."""
    return _tables()[pack]


PROBLEMS_MEMBER = "problems.json"
"""The PDDL problems of transition modeling as one JSON object: task id -> text."""

TEMPLATE_MEMBER = "virtualhome/goal_interpretation.txt"
"""The template of VirtualHome's goal interpretation, whose prompts alone are not shipped ready made."""

TEMPLATE_SOURCE = "virtualhome_eval/evaluation/goal_interpretation/prompts/one_shot.py"
"""The module of the wheel that holds it."""


def _template(wheel: Bundle, report: ReportProgress) -> dict[str, bytes]:
    """Return the members of `prompt_templates`: string constants of modules that are read, never run.

    Raises:
        DataError: the module is absent or has no such constant.
    """
    for statement in ast.parse(wheel.read(TEMPLATE_SOURCE)).body:
        match statement:
            case ast.Assign(targets=[ast.Name(id="prompt")], value=ast.Constant(value=str(template))):
                return {TEMPLATE_MEMBER: template.encode()}
    raise DataError(f"{TEMPLATE_SOURCE}: expected a constant named prompt; run `eai data fetch --force`")


def _copy_with_problems(pack: str, household: str, wheel: Bundle, report: ReportProgress) -> dict[str, bytes]:
    """Return the files of a pack, and the PDDL problems of a household as one member."""
    folder = f"virtualhome_eval/resources/{household}/problem_pddl/"
    problems = {
        PurePosixPath(name).stem: wheel.read(name).decode()
        for name in sorted(wheel.names)
        if name.startswith(folder) and name.endswith(".pddl")
    }
    return {**_copy(pack, wheel, report), PROBLEMS_MEMBER: json.dumps(problems).encode()}


def _copy(pack: str, wheel: Bundle, report: ReportProgress) -> dict[str, bytes]:
    return {member: wheel.read(path) for member, path in files_of(pack).items()}


EAI_EVAL = Archive(
    name="eai-eval",
    version="1.0.5",
    filename="eai_eval-1.0.5-py3-none-any.whl",
    sha256="fe09f2a84cfb2451e111d02a2fa57e18797e747b73de23cb036d0d4e6502099f",
    size=27_068_884,
    record_sha256="d4c8cdcd80e26e0510946b86f8eb2098b3eb30645fb15c442c4eec24176c86dc",
)
"""The reference's package: both domains' annotations, VirtualHome's graphs, the official prompts."""

RESOURCES = "virtualhome_resources"
"""Name of the pack with VirtualHome's vocabularies, PDDL problems and operators."""

BEHAVIOR_PDDL = "behavior_pddl"
"""Name of the pack with BEHAVIOR's PDDL problems and operators."""

PROMPTS = "prompts"
"""Name of the pack with the official prompts of both domains."""

TEMPLATES = "prompt_templates"
"""Name of the pack with the official templates from which prompts must be rendered."""

PUBLISHED = (
    Pack(RESOURCES, (EAI_EVAL,), partial(_copy_with_problems, RESOURCES, "virtualhome")),
    Pack(PROMPTS, (EAI_EVAL,), partial(_copy, PROMPTS)),
    Pack(BEHAVIOR_PDDL, (EAI_EVAL,), partial(_copy_with_problems, BEHAVIOR_PDDL, "behavior")),
    Pack(TEMPLATES, (EAI_EVAL,), _template),
)
"""The packs of both of the paper's households: one archive makes them all."""
