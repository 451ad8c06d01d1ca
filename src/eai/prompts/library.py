"""The prompts of a suite: from a set, with the user's own files in place of single ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from eai.abilities.protocol import Ability, Domain
from eai.abilities.responses import task_id_of
from eai.benchmarks.published_prompts import official_prompts
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.errors import InputError
from eai.prompts.own import Examples, own_prompts
from eai.prompts.prompt import Prompt, PromptSet, read_prompt_file, read_system_file
from eai.prompts.template import template_names

_SUITE_FILES = frozenset(
    f"{domain.value}_{ability.value}{ending}.json"
    for domain in Domain
    for ability in Ability
    for ending in ("", "_system")
)


@dataclass(frozen=True, slots=True)
class Library:
    """Where prompts come from.

    Attributes:
        prompts: the set.
        folder: the user's own files, or None. ``<domain>_<ability>.json`` and
            ``<domain>_<ability>_system.json`` replace prompts and system message of a suite, template files
            those of the set `eai`.
        examples: the data set's own answers, for the examples in our own prompts.
        store: where the data set is; the user's default store if None.
        report: told of a download.
    """

    prompts: PromptSet
    folder: Path | None
    examples: Examples
    store: Store | None = None
    report: Report = silent

    def open(self, domain: Domain, ability: Ability) -> Mapping[str, Prompt]:
        """The prompts of a suite by task id, in the order of the data set.

        Raises:
            DataError: the data cannot be obtained.
            InputError: a file of the user's cannot be used, or the set has no such prompts.
        """
        if self.folder is not None:
            _refuse_strangers(self.folder)
        if self.prompts is PromptSet.OFFICIAL:
            prompts = official_prompts(domain, ability, self.store, report=self.report)
        else:
            prompts = own_prompts(
                domain,
                ability,
                self.examples(domain, ability),
                self.store,
                folder=self.folder,
                report=self.report,
            )
        return self._with_own_files(prompts, f"{domain.value}_{ability.value}")

    def _with_own_files(self, prompts: Mapping[str, Prompt], name: str) -> Mapping[str, Prompt]:
        if self.folder is None:
            return prompts
        file, system_file = self.folder / f"{name}.json", self.folder / f"{name}_system.json"
        if file.exists():
            own = {task_id_of(i): text for i, text in read_prompt_file(file).items()}
            for task_id in own:
                if task_id not in prompts:
                    raise InputError(f"{file}: identifier {task_id!r} is not one of the tasks")
            prompts = {i: replace(prompt, user=own.get(i, prompt.user)) for i, prompt in prompts.items()}
        if system_file.exists():
            system = read_system_file(system_file)
            prompts = {i: replace(prompt, system=system) for i, prompt in prompts.items()}
        return prompts


def _refuse_strangers(folder: Path) -> None:
    """Raise if this is no folder, or has prompts or templates that replace nothing."""
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of prompts")
    known = _SUITE_FILES | template_names()
    for file in sorted([*folder.rglob("*.json"), *folder.rglob("*.txt")]):
        if file.relative_to(folder).as_posix() not in known:
            raise InputError(
                f"{file}: replaces nothing; expected <domain>_<ability>.json, "
                "<domain>_<ability>_system.json or the name of a template"
            )
