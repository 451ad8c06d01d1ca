from __future__ import annotations

from dataclasses import replace

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome.domain import as_meant
from eai.world.conformance import check
from eai.world.domain import Domain
from eai.world.fault import FaultKind

WORN = ("ONTOP shirt.17 character.65", "NEXT_TO character.65 shirt.17")
SITUATIONS: tuple[tuple[str, ...], ...] = (
    ("NEXT_TO character.65 television.22", "NEXT_TO character.65 bed.20"),
    ("NEXT_TO character.65 fridge.10", "-OFF fridge.10"),
    ("NEXT_TO character.65 fridge.10", "-OFF fridge.10", "ON fridge.10"),
    (*WORN, "TAKEN_FROM_TOP_OF shirt.17 bed.20"),
    ("SITTING character.65", "ONTOP character.65 chair.21", "NEXT_TO character.65 bed.20"),
    ("LYING character.65", "NEXT_TO character.65 bed.20"),
)
"""The flat as an action can find it when it seems needless."""


def problems(domain: Domain) -> set[str]:
    """What does not conform when each action that can be additional is tried by itself, on all objects."""
    states = [flat.state(*situation) for situation in SITUATIONS]
    alone = [
        replace(domain, operators=(operator,))
        for operator in domain.operators
        if any(each.fault is FaultKind.ADDITIONAL_STEP for each in operator.checks)
    ]
    return {defect for each in alone for defect in check(each, states, steps=100)}


def test_it_conforms() -> None:
    assert not problems(as_meant())
