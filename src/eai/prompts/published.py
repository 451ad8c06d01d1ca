"""Published prompts: those that come with a data set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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
        """The same as files, byte for byte where the data set ships them and they ask for what is scored.

        Raises:
            DataError: they cannot be obtained.
        """
        ...
