"""The official prompts: those of the data set, byte for byte."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.protocol import Ability, Domain
from eai.abilities.responses import SCENE_PREFIX
from eai.data.dataset import open_pack
from eai.data.packs import PROMPTS
from eai.data.progress import Report, silent
from eai.data.store import Store


@dataclass(frozen=True, slots=True)
class Prompt:
    """What a model is asked: an optional system message and a user message."""

    user: str
    system: str | None = None


def official_prompts(
    domain: Domain, ability: Ability, store: Store | None = None, *, report: Report = silent
) -> Mapping[str, Prompt]:
    """The data set's prompts by task id, in its order.

    Raises:
        DataError: the prompts cannot be obtained, or the data set has none for this ability.
    """
    pack = open_pack(PROMPTS, store, report=report)
    name = f"{domain.value}/{ability.value}"
    system_member = f"{name}_system.json"
    system = None
    if system_member in pack.manifest.members:
        system = pack.read_json(system_member)["system_prompt"]
    rows = pack.read_json(f"{name}.json")
    return {row["identifier"].removeprefix(SCENE_PREFIX): Prompt(row["llm_prompt"], system) for row in rows}
