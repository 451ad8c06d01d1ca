from __future__ import annotations

import pytest

from eai.households.virtualhome.domain import as_meant
from eai.reference.quirk import Quirk
from eai.reference.virtualhome_quirks import QUIRKS
from households.virtualhome.test_conformance import problems


@pytest.mark.parametrize(
    "quirk",
    [quirk for quirk in QUIRKS if quirk.name.endswith("is_additional")],
    ids=lambda quirk: quirk.name,
)
def test_the_references_additional_steps_would_still_bring_something_about(quirk: Quirk) -> None:
    found = problems(quirk.apply(as_meant()))
    assert found
    assert all("an additional step that would bring about" in problem for problem in found)
