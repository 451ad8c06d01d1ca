from __future__ import annotations

from dataclasses import replace

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_paper_order
from eai.world.conformance import check_domain
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
"""Initial facts under which some actions are unnecessary."""


def find_problems(domain: Domain) -> set[str]:
    """Return the defects of each action with an additional-step check, tried alone on all objects."""
    states = [flat.make_state(*situation) for situation in SITUATIONS]
    domains = [
        replace(domain, operators=(operator,))
        for operator in domain.operators
        if any(rule.fault is FaultKind.ADDITIONAL_STEP for rule in operator.checks)
    ]
    return {defect for single in domains for defect in check_domain(single, states, steps=100)}


def test_the_domain_conforms_to_its_declarations() -> None:
    assert not find_problems(make_domain_with_checks_in_paper_order())
