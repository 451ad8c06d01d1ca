from __future__ import annotations

import pytest

from eai.results.certainty import two_sided_quantile


@pytest.mark.parametrize(
    ("freedom", "quantile"),
    [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (16, 2.120), (99, 1.984), (1000, 1.962)],
)
def test_quantiles_are_those_of_printed_tables(freedom: int, quantile: float) -> None:
    assert two_sided_quantile(0.95, freedom) == pytest.approx(quantile, abs=0.0005)
