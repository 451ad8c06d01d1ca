from __future__ import annotations

from collections.abc import Callable

import pytest

from benchmarks.virtualhome.test_conformance import find_problems
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_paper_order
from eai.extensions.reference.virtualhome_quirks import QUIRKS
from eai.world.domain import Domain


@pytest.mark.parametrize(
    "quirk",
    [quirk for quirk in QUIRKS if quirk.__name__.endswith("as_additional_step")],
    ids=lambda quirk: quirk.__name__,
)
def test_the_references_additional_steps_would_still_bring_something_about(
    quirk: Callable[[Domain], Domain],
) -> None:
    found = find_problems(quirk(make_domain_with_checks_in_paper_order()))
    assert found
    assert all("an additional step that would bring about" in problem for problem in found)
