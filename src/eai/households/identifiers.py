"""How published files identify the tasks of the two households."""

from __future__ import annotations

import re

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
