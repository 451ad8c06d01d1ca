"""References to tasks, such as ``virtualhome/action_sequencing/27_2``, and names of suites."""

from __future__ import annotations

from typing import NamedTuple

from eai.abilities.protocol import Ability, find_ability_entry_points
from eai.base.errors import InputError

OBFUSCATED, WITH_RULES = "-obfuscated", "-rules"
"""Endings of names of benchmarks that have the tasks of another benchmark, but different prompts."""


class TaskReference(NamedTuple):
    """A task by benchmark, ability and id, written ``virtualhome/action_sequencing/27_2``.

    The benchmark may be any text that `eai.benchmarks.registry.find_benchmark` accepts, such as a path.
    """

    benchmark: str
    ability: Ability
    task_id: str

    def __str__(self) -> str:
        return f"{self.benchmark}/{self.ability.value}/{self.task_id}"

    @staticmethod
    def parse(text: str) -> TaskReference:
        """Parse a reference to a task, such as BENCHMARK/ABILITY/TASK.

        If several parts between slashes are names of abilities, the last of them is the ability.

        Raises:
            InputError: the text is not a reference to a task.
        """
        parts = text.split("/") if isinstance(text, str) else []
        for position in range(len(parts) - 2, 0, -1):
            ability = Ability(parts[position])
            if ability in find_ability_entry_points():
                return TaskReference("/".join(parts[:position]), ability, "/".join(parts[position + 1 :]))
        raise InputError(f"{text!r:.102} is not a task: expected BENCHMARK/ABILITY/TASK")


def suite_name(domain: str, ability: Ability) -> str:
    """Return the name of a suite (a benchmark and an ability), for Inspect tasks and files of prompts."""
    return f"{domain}_{ability.value}"


def remove_prompt_variant_endings(name: str) -> str:
    """Return the name of a benchmark without the endings ``-obfuscated`` and ``-rules``.

    A name with such an ending denotes the tasks of the benchmark with other prompts.
    """
    return name.removesuffix(OBFUSCATED).removesuffix(WITH_RULES)
