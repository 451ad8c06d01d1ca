"""Make data packages of VirtualHome and BEHAVIOR from the paper's wheel, and read the wheel's task ids.

A data package, called a pack, is made from downloaded archives. Most packs copy files of the wheel byte for
byte, under our own file names (`packs.toml`).
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
from eai.base.source import ArchiveFiles, PackageArchive
from eai.base.store import ReportProgress
from eai.benchmarks.packs import DataPack

SCENE_PREFIX = "scene_1_"

_OTHER_SCENE = re.compile(r"scene_(?!1_)\d+_")
"""Prefix of the ids of tasks in unpublished scenes. The challenge of the paper's authors used them."""

_CORRECTED_IDS = {
    "cleaning_up_after_a_meal_0_Merom_1_int_0_2021-06-06_19-55-27": (
        "cleaning_up_after_a_meal_0_Wainscott_0_int_0_2021-10-20_05-33-24"
    )
}
"""Wrong task id in the published prompts of BEHAVIOR's goal interpretation -> right id."""


def get_task_id_of_published_id(published_id: str) -> str:
    """Return the task id in the data set for an identifier in a file of answers or prompts."""
    task_id = published_id.removeprefix(SCENE_PREFIX)
    return _CORRECTED_IDS.get(task_id, task_id)


def find_task_id(published_id: str) -> str | None:
    """Return the data set's task id for an identifier in published files. None for unpublished scenes."""
    return None if _OTHER_SCENE.match(published_id) else get_task_id_of_published_id(published_id)


@cache
def _load_wheel_path_by_pack_and_file() -> Mapping[str, Mapping[str, str]]:
    return parse_toml((files("eai.benchmarks") / "packs.toml").read_text(encoding="utf-8"))


def map_data_pack_files_to_wheel_paths(pack_name: str) -> Mapping[str, str]:
    """Return a mapping from the files of a data package (pack) to their paths in the wheel."""
    return _load_wheel_path_by_pack_and_file()[pack_name]


PROBLEMS_MEMBER = "problems.json"
"""Name of the member file with PDDL problems of transition modeling: a JSON object, task id -> problem."""

TEMPLATE_MEMBER = "virtualhome/goal_interpretation.txt"
"""Name of the file with the template of VirtualHome's prompts for goal interpretation.

All other prompts need no template: the wheel, the paper's Python package, contains their texts.
"""

TEMPLATE_SOURCE = "virtualhome_eval/evaluation/goal_interpretation/prompts/one_shot.py"
"""Path of the Python module with this template in the wheel of the paper's package."""


def _extract_prompt_template(wheel: ArchiveFiles, report: ReportProgress) -> dict[str, bytes]:
    """Return the template of prompts. It is a constant in a module, which is parsed, but never executed.

    Raises:
        DataError: the module is absent, or has no such constant.
    """
    for statement in ast.parse(wheel.read(TEMPLATE_SOURCE)).body:
        match statement:
            case ast.Assign(targets=[ast.Name(id="prompt")], value=ast.Constant(value=str(template))):
                return {TEMPLATE_MEMBER: template.encode()}
    raise DataError(f"{TEMPLATE_SOURCE}: expected a constant named prompt; run `eai data fetch --force`")


def _extract_pack_files_and_problems_from_wheel(
    pack: str, resource_folder: str, wheel: ArchiveFiles, report: ReportProgress
) -> dict[str, bytes]:
    """Return the files of a data package by name, with all PDDL problems in one JSON file."""
    folder = f"virtualhome_eval/resources/{resource_folder}/problem_pddl/"
    problems = {
        PurePosixPath(name).stem: wheel.read(name).decode()
        for name in sorted(wheel.names)
        if name.startswith(folder) and name.endswith(".pddl")
    }
    return {
        **_extract_pack_files_from_wheel(pack, wheel, report),
        PROBLEMS_MEMBER: json.dumps(problems).encode(),
    }


def _extract_pack_files_from_wheel(
    pack: str, wheel: ArchiveFiles, report: ReportProgress
) -> dict[str, bytes]:
    return {member: wheel.read(path) for member, path in map_data_pack_files_to_wheel_paths(pack).items()}


EAI_EVAL = PackageArchive(
    name="eai-eval",
    version="1.0.5",
    filename="eai_eval-1.0.5-py3-none-any.whl",
    sha256="fe09f2a84cfb2451e111d02a2fa57e18797e747b73de23cb036d0d4e6502099f",
    size=27_068_884,
    record_sha256="d4c8cdcd80e26e0510946b86f8eb2098b3eb30645fb15c442c4eec24176c86dc",
)
"""The wheel of the paper's package. It has annotations, scene graphs and the official prompts."""

RESOURCES = "virtualhome_resources"
"""Name of the data package (pack) with VirtualHome's vocabularies, PDDL problems and operators."""

BEHAVIOR_PDDL = "behavior_pddl"
"""Name of the data package (pack) with BEHAVIOR's PDDL problems and operators."""

PROMPTS = "prompts"
"""Name of the data package (pack) with the official prompts of VirtualHome and BEHAVIOR."""

TEMPLATES = "prompt_templates"
"""Name of the data package (pack) with the template of VirtualHome's goal interpretation prompts."""

PUBLISHED = (
    DataPack(
        RESOURCES, (EAI_EVAL,), partial(_extract_pack_files_and_problems_from_wheel, RESOURCES, "virtualhome")
    ),
    DataPack(PROMPTS, (EAI_EVAL,), partial(_extract_pack_files_from_wheel, PROMPTS)),
    DataPack(
        BEHAVIOR_PDDL,
        (EAI_EVAL,),
        partial(_extract_pack_files_and_problems_from_wheel, BEHAVIOR_PDDL, "behavior"),
    ),
    DataPack(TEMPLATES, (EAI_EVAL,), _extract_prompt_template),
)
"""Data packages (packs) that are made from only the Python wheel of the paper's package eai-eval."""
