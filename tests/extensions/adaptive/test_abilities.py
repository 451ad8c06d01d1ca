from __future__ import annotations

import pytest

pytest.importorskip("scipy")

from extensions.adaptive.abilities import ability
from studies.test_effects import must_hold_the_truth


def test_intervals_of_abilities_hold_the_truth() -> None:
    must_hold_the_truth(ability)
