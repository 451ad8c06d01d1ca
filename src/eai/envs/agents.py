"""Agents for environments that need no model: what others are to be compared with."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import Any

from eai.errors import InputError


class RandomAgent:
    """`eai/random`: takes any of the admissible commands; of the same seed the same ones.

    The environment has to list them: ``make(..., admissible=True)``.

    Args:
        seed: of its choices.
    """

    def __init__(self, seed: int = 0) -> None:
        self._random = random.Random(seed)  # noqa: S311 - chance, not secrets

    def __call__(self, observation: str, info: Mapping[str, Any]) -> str:
        """The next command.

        Raises:
            InputError: the environment does not list admissible commands, or there are none.
        """
        commands: Sequence[str] = info.get("admissible_commands", ())
        if not commands:
            raise InputError("eai/random needs admissible commands: make(..., admissible=True)")
        return self._random.choice(commands)
