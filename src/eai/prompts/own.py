"""Our own prompts, rendered from a domain's declaration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from eai.abilities.protocol import Ability, Domain
from eai.data.progress import Report
from eai.data.store import Store
from eai.errors import InputError
from eai.prompts.prompt import Prompt

Example: TypeAlias = Callable[[str], str]
"""The data set's own answer to a task, by id."""

Examples: TypeAlias = Callable[[Domain, Ability], Example]
"""The data set's own answers of a suite."""


def own_prompts(
    domain: Domain,
    ability: Ability,
    example: Example,
    store: Store | None,
    *,
    folder: Path | None,
    report: Report,
) -> Mapping[str, Prompt]:
    """Not there yet.

    Raises:
        InputError: always.
    """
    raise InputError(f"there are no own prompts for {domain.value} {ability.value} yet")
