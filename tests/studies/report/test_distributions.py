from __future__ import annotations

from pathlib import Path

import pytest

from eai.studies.report.distributions import (
    _ValueDistribution,
    group_counts_into_bins,
    write_distribution_plots,
)

pytest.importorskip("matplotlib")


def test_bins_are_labelled_with_their_bounds_and_leave_no_gap() -> None:
    assert group_counts_into_bins({1: 2, 3: 1}, by_decades=False) == {"1": 2, "2": 0, "3": 1}
    wide = group_counts_into_bins({2: 1, 67: 3}, by_decades=False)
    assert next(iter(wide)) == "0-4"
    assert wide["65-69"] == 3
    assert sum(wide.values()) == 4


def test_decades_are_labelled_with_their_first_number() -> None:
    assert group_counts_into_bins({1: 70, 9: 12, 10: 7, 4_000: 1}, by_decades=True) == {
        "1-9": 82,
        "10+": 7,
        "100+": 0,
        "1,000+": 1,
    }


def test_files_of_distributions_are_reproducible(tmp_path: Path) -> None:
    found = (
        _ValueDistribution("steps", "Steps", "tasks", {2: 1, 5: 3}),
        _ValueDistribution("actions", "Actions", "steps", {"GO": 3, "a$b": 1}),
    )
    first = [path.read_bytes() for path in write_distribution_plots(found, "Toy", tmp_path / "toy")]
    assert [path.name for path in write_distribution_plots(found, "Toy", tmp_path / "toy")] == [
        "toy-numbers.svg",
        "toy-numbers.png",
        "toy-numbers.pdf",
        "toy-names.svg",
        "toy-names.png",
        "toy-names.pdf",
    ]
    assert first == [path.read_bytes() for path in write_distribution_plots(found, "Toy", tmp_path / "toy")]
