"""How published files identify the tasks of the two households."""

from __future__ import annotations

SCENE_PREFIX = "scene_1_"

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
