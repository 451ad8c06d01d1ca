"""The official prompts: those of the data set, byte for byte."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.protocol import Ability, Domain
from eai.abilities.responses import task_id_of
from eai.benchmarks.packs import PROMPTS, open_published
from eai.benchmarks.virtualhome.goal_prompts import goal_interpretation_prompts
from eai.data.progress import Report, silent
from eai.data.store import PackFile, Store
from eai.prompts.prompt import Prompt, prompt_file


@dataclass(frozen=True, slots=True)
class OfficialFiles:
    """The prompts of a suite as the data set ships them.

    Attributes:
        prompts: content of the file of prompts.
        system: content of the file with the system message, or None where the prompts have none.
    """

    prompts: bytes
    system: bytes | None


def official_prompts(
    domain: Domain, ability: Ability, store: Store | None = None, *, report: Report = silent
) -> Mapping[str, Prompt]:
    """The official prompts by task id, in the order of the data set.

    Raises:
        DataError: they cannot be obtained.
    """
    pack = open_published(PROMPTS, store, report=report)
    if _is_rendered(pack, domain, ability):
        rendered = goal_interpretation_prompts(store, report=report)
        return {task_id: Prompt(text) for task_id, text in rendered.items()}
    setup = (
        pack.read_json(_setup(domain, ability)) if _setup(domain, ability) in pack.manifest.members else {}
    )
    system, stop = setup.get("system_prompt"), tuple(setup.get("stop_sequences", ()))
    rows = pack.read_json(_member(domain, ability))
    return {task_id_of(row["identifier"]): Prompt(row["llm_prompt"], system, stop) for row in rows}


def official_files(
    domain: Domain, ability: Ability, store: Store | None = None, *, report: Report = silent
) -> OfficialFiles:
    """The files of a suite's prompts, byte for byte where the data set ships them.

    Raises:
        DataError: they cannot be obtained.
    """
    pack = open_published(PROMPTS, store, report=report)
    if _is_rendered(pack, domain, ability):
        return OfficialFiles(prompt_file(official_prompts(domain, ability, store, report=report)), None)
    setup = _setup(domain, ability)
    system = pack.read(setup) if setup in pack.manifest.members else None
    return OfficialFiles(pack.read(_member(domain, ability)), system)


def _is_rendered(pack: PackFile, domain: Domain, ability: Ability) -> bool:
    """Whether the data set ships only a template: VirtualHome's goal interpretation."""
    return _member(domain, ability) not in pack.manifest.members


def _member(domain: Domain, ability: Ability) -> str:
    return f"{domain.value}/{ability.value}.json"


def _setup(domain: Domain, ability: Ability) -> str:
    return f"{domain.value}/{ability.value}_system.json"
