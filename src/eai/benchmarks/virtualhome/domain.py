"""The VirtualHome domain: a household of some 300 objects, one character, 45 actions."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, reduce

from eai.benchmarks.reference.virtualhome_quirks import QUIRKS
from eai.benchmarks.virtualhome.operators import declared_operators
from eai.benchmarks.virtualhome.predicates import VOCABULARY, R, X, room_of
from eai.world.domain import Domain
from eai.world.operator import in_paper_order

__all__ = ["as_in_reference", "as_meant"]


@cache
def as_meant() -> Domain:
    """The domain of protocol `strict`: checks in the paper's order, defects of the reference mended."""
    declared = _declared()
    return replace(declared, operators=tuple(in_paper_order(o) for o in declared.operators))


@cache
def as_in_reference() -> Domain:
    """The domain of protocol `eai-1.0.5`: the reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, _declared())


def _declared() -> Domain:
    return Domain("virtualhome", VOCABULARY, declared_operators(room_of_held=room_of(X, R)))
