"""How an answer is written, in words: the texts that a benchmark puts into its prompts."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files

from eai.abilities.protocol import Ability

FOLDER = "formats"


def formats_of(package: str) -> Mapping[Ability, str]:
    """The texts in the folder ``formats`` of a package, by ability; an ability without one has no entry."""
    folder = files(package) / FOLDER
    found = {ability: folder / f"{ability.value}.txt" for ability in Ability}
    return {
        ability: file.read_text(encoding="utf-8").removesuffix("\n")
        for ability, file in found.items()
        if file.is_file()
    }
