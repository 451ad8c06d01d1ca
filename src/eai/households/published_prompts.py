"""The official prompts: those of the data set, byte for byte."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from eai.abilities.protocol import Ability
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.households.identifiers import task_id_of
from eai.households.packs import PROMPTS, open_published
from eai.prompts.prompt import Prompt, prompt_file
from eai.prompts.published import PromptFiles

Render = Callable[[Store | None, Report], Mapping[str, str]]
"""Renders prompts of which the data set ships only a template: task id -> question."""


@dataclass(frozen=True, slots=True)
class OfficialPrompts:
    """The official prompts of one benchmark.

    Attributes:
        name: the benchmark's folder in the pack of prompts.
        rendered: the abilities whose prompts the data set ships as a template only, and how to render them.
    """

    name: str
    rendered: Mapping[Ability, Render] = field(default_factory=dict)

    def prompts(
        self, ability: Ability, store: Store | None = None, *, report: Report = silent
    ) -> Mapping[str, Prompt]:
        """The prompts by task id, in the order of the data set.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return {i: Prompt(text) for i, text in self.rendered[ability](store, report).items()}
        pack = open_published(PROMPTS, store, report=report)
        setup = self._setup(ability)
        settings = pack.read_json(setup) if setup in pack.manifest.members else {}
        system, stop = settings.get("system_prompt"), tuple(settings.get("stop_sequences", ()))
        rows = pack.read_json(self._member(ability))
        return {task_id_of(row["identifier"]): Prompt(row["llm_prompt"], system, stop) for row in rows}

    def files(self, ability: Ability, store: Store | None = None, *, report: Report = silent) -> PromptFiles:
        """The files of the prompts, byte for byte where the data set ships them.

        Raises:
            DataError: they cannot be obtained.
        """
        if ability in self.rendered:
            return PromptFiles(prompt_file(self.prompts(ability, store, report=report)), None)
        pack = open_published(PROMPTS, store, report=report)
        setup = self._setup(ability)
        system = pack.read(setup) if setup in pack.manifest.members else None
        return PromptFiles(pack.read(self._member(ability)), system)

    def _member(self, ability: Ability) -> str:
        return f"{self.name}/{ability.value}.json"

    def _setup(self, ability: Ability) -> str:
        return f"{self.name}/{ability.value}_system.json"
