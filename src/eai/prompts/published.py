"""Published prompts: those that come with a data set."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from eai.abilities.protocol import Ability
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.prompts.prompt import Prompt


@dataclass(frozen=True, slots=True)
class PromptFiles:
    """The prompts of a suite as the data set ships them.

    Attributes:
        prompts: content of the file of prompts.
        system: content of the file with the system message, or None where the prompts have none.
    """

    prompts: bytes
    system: bytes | None

    def corrected(self, correct: Callable[[str, str], str]) -> PromptFiles:
        """The same files with other questions.

        Args:
            correct: from an identifier and its question to the question that is asked.
        """
        rows = json.loads(self.prompts)
        for row in rows:
            row["llm_prompt"] = correct(row["identifier"], row["llm_prompt"])
        return replace(self, prompts=json.dumps(rows, indent=4).encode())


class PublishedPrompts(Protocol):
    """The prompts of a benchmark that its data set has."""

    def prompts(
        self, ability: Ability, store: Store | None = None, *, report: Report = silent
    ) -> Mapping[str, Prompt]:
        """The prompts by task id, in the order of the data set.

        Raises:
            DataError: they cannot be obtained.
        """
        ...

    def files(self, ability: Ability, store: Store | None = None, *, report: Report = silent) -> PromptFiles:
        """The same as files, byte for byte where the data set ships them.

        Raises:
            DataError: they cannot be obtained.
        """
        ...
