"""The VirtualHome domain as eai-eval 1.0.5 has it."""

from __future__ import annotations

from functools import cache, reduce

from eai.households.virtualhome.domain import as_declared
from eai.reference.virtualhome_quirks import QUIRKS
from eai.world.domain import Domain


@cache
def as_in_reference() -> Domain:
    """The reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, as_declared())
