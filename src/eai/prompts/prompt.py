"""Prompts as values, and the file in which the reference exchanges them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from eai.errors import InputError


class PromptSet(str, Enum):
    """Which prompts a model is asked: the data set's, or ours, rendered from a domain's declaration."""

    OFFICIAL = "official"
    EAI = "eai"


@dataclass(frozen=True, slots=True)
class Prompt:
    """What a model is asked.

    Attributes:
        user: the question.
        system: the system message, or None.
        stop: the sequences at which the paper's runs cut the answer; what ends with one lacks it.
    """

    user: str
    system: str | None = None
    stop: tuple[str, ...] = ()

    @property
    def sha256(self) -> str:
        """Digest of all text that the model is shown: the user message alone, or both with a zero between."""
        text = self.user if self.system is None else f"{self.system}\0{self.user}"
        return hashlib.sha256(text.encode()).hexdigest()


def prompt_file(prompts: Mapping[str, Prompt]) -> bytes:
    """Prompts in the reference's shape, a list of ``{"identifier", "llm_prompt"}``; no system messages."""
    rows = [{"identifier": task_id, "llm_prompt": prompt.user} for task_id, prompt in prompts.items()]
    return json.dumps(rows, indent=4).encode()


def system_file(prompts: Mapping[str, Prompt]) -> bytes | None:
    """The system message that all prompts share as ``{"system_prompt"}``, or None if they have none."""
    system = next((prompt.system for prompt in prompts.values()), None)
    return None if system is None else json.dumps({"system_prompt": system}, indent=4).encode()


def read_prompt_file(path: Path) -> dict[str, str]:
    """The prompts of a file in the reference's shape, by identifier.

    Raises:
        InputError: the file cannot be read, or is not of this shape.
    """
    try:
        rows = TypeAdapter(list[_Row]).validate_json(path.read_bytes())
    except (OSError, ValidationError) as error:
        raise InputError(f'{path}: expected a list of {{"identifier", "llm_prompt"}} ({error})') from error
    return {row["identifier"]: row["llm_prompt"] for row in rows}


def read_system_file(path: Path) -> str:
    """The system message of a file ``{"system_prompt"}``.

    Raises:
        InputError: the file cannot be read, or is not of this shape.
    """
    try:
        return TypeAdapter(_System).validate_json(path.read_bytes())["system_prompt"]
    except (OSError, ValidationError) as error:
        raise InputError(f'{path}: expected {{"system_prompt"}} ({error})') from error


class _Row(TypedDict):
    identifier: str
    llm_prompt: str


class _System(TypedDict):
    system_prompt: str
