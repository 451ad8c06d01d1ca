"""Files of the wheel that the store keeps byte for byte, under names of ours, and how they identify tasks."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Mapping
from pathlib import PurePosixPath

from eai.data.source import Bundle
from eai.errors import DataError

SCENE_PREFIX = "scene_1_"

_OTHER_SCENE = re.compile(r"scene_(?!1_)\d+_")
"""How the challenge's final phase identifies tasks in scenes that are not published."""

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


_VIRTUALHOME = "virtualhome_eval/resources/virtualhome/"
_BEHAVIOR = "virtualhome_eval/resources/behavior/"

RESOURCE_FILES: Mapping[str, str] = {
    # The copy of the vocabulary beside the others lacks WIPE, and the reference does not read it.
    "vocabulary.json": "virtualhome_eval/resources/vocabulary.json",
    "object_states_full.json": "virtualhome_eval/resources/object_states_full.json",
    **{
        name: _VIRTUALHOME + name
        for name in (
            "relation_types.json",
            "relation_object_pairs.json",
            "action_space.json",
            "id2task.json",
            "id2action.json",
            "id2category_2.json",
            "gold_action.json",
            "gold_pddl_plan.json",
            "predicates_category.json",
            "success_task.json",
            "virtualhome_pd.pddl",
        )
    },
}
"""Member of the pack `virtualhome_resources` -> file of the wheel."""

BEHAVIOR_PDDL_FILES: Mapping[str, str] = {
    name: _BEHAVIOR + name
    for name in (
        "id2action.json",
        "id2category_2.json",
        "gold_action.json",
        "gold_pddl_plan.json",
        "predicates_category.json",
        "success_task.json",
        "behavior_pd.pddl",
    )
}
"""Member of the pack `behavior_pddl` -> file of the wheel."""

PROBLEMS_MEMBER = "problems.json"
"""The PDDL problems of transition modeling as one JSON object: task id -> text."""

PROMPT_FILES: Mapping[str, str] = {
    **{
        f"{domain}/{ability}.json": f"{domain}_eval/evaluation/{ability}/{folder}/helm_prompts.json"
        for domain, folder in (("virtualhome", "prompts"), ("behavior", "resources/prompts"))
        for ability in ("action_sequencing", "subgoal_decomposition", "transition_modeling")
    },
    "behavior/goal_interpretation.json": (
        "behavior_eval/evaluation/goal_interpretation/resources/prompts/user_prompts.json"
    ),
    "behavior/goal_interpretation_system.json": (
        "behavior_eval/evaluation/goal_interpretation/resources/prompts/system_setup.json"
    ),
    "behavior/subgoal_decomposition_system.json": (
        "behavior_eval/evaluation/subgoal_decomposition/resources/prompts/system_setup.json"
    ),
    "virtualhome/subgoal_decomposition_system.json": (
        "virtualhome_eval/evaluation/subgoal_decomposition/prompts/system_setup.json"
    ),
}
"""Member of the pack `prompts` -> file of the wheel. VirtualHome's goal interpretation ships no prompts."""


TEMPLATE_MEMBER = "virtualhome/goal_interpretation.txt"
"""The template of VirtualHome's goal interpretation, whose prompts alone are not shipped ready made."""

TEMPLATE_SOURCE = "virtualhome_eval/evaluation/goal_interpretation/prompts/one_shot.py"
"""The module of the wheel that holds it."""


def convert_resources(wheel: Bundle) -> dict[str, bytes]:
    """The members of the pack `virtualhome_resources`; DataError when a file is absent."""
    return {**_copy(wheel, RESOURCE_FILES), PROBLEMS_MEMBER: _problems(wheel, _VIRTUALHOME)}


def convert_behavior_pddl(wheel: Bundle) -> dict[str, bytes]:
    """The members of the pack `behavior_pddl`; DataError when a file is absent."""
    return {**_copy(wheel, BEHAVIOR_PDDL_FILES), PROBLEMS_MEMBER: _problems(wheel, _BEHAVIOR)}


def convert_prompts(wheel: Bundle) -> dict[str, bytes]:
    """The members of the pack `prompts`; DataError when a file is absent."""
    return _copy(wheel, PROMPT_FILES)


def convert_templates(wheel: Bundle) -> dict[str, bytes]:
    """The members of the pack `prompt_templates`: string constants of modules that are read, never run.

    Raises:
        DataError: the module is absent or has no such constant.
    """
    for statement in ast.parse(wheel.read(TEMPLATE_SOURCE)).body:
        match statement:
            case ast.Assign(targets=[ast.Name(id="prompt")], value=ast.Constant(value=str(template))):
                return {TEMPLATE_MEMBER: template.encode()}
    raise DataError(f"{TEMPLATE_SOURCE}: expected a constant named prompt; run `eai data fetch --force`")


def _problems(wheel: Bundle, folder: str) -> bytes:
    problems = {
        PurePosixPath(name).stem: wheel.read(name).decode()
        for name in sorted(wheel.names)
        if name.startswith(f"{folder}problem_pddl/") and name.endswith(".pddl")
    }
    return json.dumps(problems).encode()


def _copy(wheel: Bundle, files: Mapping[str, str]) -> dict[str, bytes]:
    return {member: wheel.read(path) for member, path in files.items()}
