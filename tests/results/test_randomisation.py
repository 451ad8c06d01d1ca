from __future__ import annotations

import random
from collections.abc import Sequence
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.verdict import Share
from eai.results.certainty import Case
from eai.results.comparison import exchange_p, sign_flip_p
from results.near_copies import merged, successes


@pytest.mark.parametrize(
    ("lost", "won", "p_value"),
    [(0, 0, 1.0), (1, 1, 1.0), (1, 9, 22 / 1024), (9, 1, 22 / 1024), (0, 5, 2 / 32)],
)
def test_of_single_tasks_it_is_mcnemar_s_test(lost: int, won: int, p_value: float) -> None:
    assert sign_flip_p([-1] * lost + [1] * won + [0] * 7) == pytest.approx(p_value)


def test_many_pairs() -> None:
    assert 0 < sign_flip_p([-1] * 900 + [1] * 1000) < 0.05
    assert sign_flip_p([1] * 2000) == 0.0


@given(st.lists(st.integers(-9, 9), max_size=8))
def test_all_signs_are_tried(differences: list[int]) -> None:
    sums = [
        sum(s * d for s, d in zip(signs, differences, strict=True))
        for signs in product((1, -1), repeat=len(differences))
    ]
    extreme = sum(abs(each) >= abs(sum(differences)) for each in sums)
    assert sign_flip_p(differences) == pytest.approx(extreme / len(sums))


def test_exchanges_find_what_sign_flips_find() -> None:
    first = [Share(k, 10) for k in (3, 5, 1, 7, 2, 9, 4, 6, 0, 2)]
    second = [Share(k, 10) for k in (4, 7, 2, 7, 5, 9, 3, 8, 2, 5)]
    exact = sign_flip_p([round(b.numerator - a.numerator) for a, b in zip(first, second, strict=True)])
    assert exchange_p(first, second) == pytest.approx(exact, abs=0.01)
    assert exchange_p(first, second) == exchange_p(first, second)
    assert exchange_p(first, first) == 1
    assert exchange_p(first, [Share(0, 0)] * 10) is None


def test_runs_that_are_alike_seldom_differ() -> None:
    """With the task as unit two models that are equally good differ in most samples of near copies."""
    generator = random.Random(5)
    by_name = by_task = 0
    for _ in range(100):
        runs = [successes(generator, 0.5) for _ in range(2)]
        by_task += sign_flip_p(_changes(*runs)) < 0.05
        by_name += sign_flip_p(_changes(*map(merged, runs))) < 0.05
    assert by_name <= 9  # 5 are expected
    assert by_task > 50


def _changes(first: Sequence[Case], second: Sequence[Case]) -> list[int]:
    return [round(b.share.numerator - a.share.numerator) for a, b in zip(first, second, strict=True)]
