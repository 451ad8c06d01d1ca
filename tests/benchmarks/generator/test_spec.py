"""Tiers of generated tasks: every length belongs to one tier, as docs/generated-tasks.md states."""

from __future__ import annotations

import pytest

from eai.benchmarks.generator.spec import LENGTHS, PlanLengthTier, TaskSpecification, get_tier_of_length


@pytest.mark.parametrize(
    ("least", "greatest", "tier"),
    [
        (3, 6, PlanLengthTier.S),
        (7, 12, PlanLengthTier.M),
        (13, 24, PlanLengthTier.L),
        (25, 48, PlanLengthTier.XL),
        (49, 96, PlanLengthTier.XXL),
    ],
)
def test_a_tier_has_all_lengths_from_its_least_to_its_greatest(
    least: int, greatest: int, tier: PlanLengthTier
) -> None:
    assert LENGTHS[tier] == (least, greatest)
    assert {get_tier_of_length(steps) for steps in range(least, greatest + 1)} == {tier}


def test_only_changed_worlds_get_a_new_version_of_the_generator() -> None:
    versions = {
        like: TaskSpecification(like, "").version
        for like in ("virtualhome", "behavior", "rules:behavior", "lamps:lamps")
    }
    assert versions == {"virtualhome": 8, "behavior": 9, "rules:behavior": 9, "lamps:lamps": 8}
    assert TaskSpecification("behavior", "", version=8).sha256 != TaskSpecification("behavior", "").sha256
