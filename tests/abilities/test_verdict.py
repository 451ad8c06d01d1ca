from __future__ import annotations

import pytest

from eai.abilities.verdict import GoalTallies, Tally


@pytest.mark.parametrize(
    ("tallies", "satisfied"),
    [
        ([(0, 0), (0, 0), (0, 0)], True),
        ([(1, 1), (2, 2), (0, 0)], True),
        ([(1, 1), (1, 2), (0, 0)], False),
        ([(0, 1), (2, 2), (1, 1)], False),
        ([(1, 1), (2, 2), (0, 1)], False),
    ],
)
def test_all_goals_are_satisfied_if_those_of_every_kind_are(
    tallies: list[tuple[int, int]], *, satisfied: bool
) -> None:
    assert GoalTallies(*(Tally(*tally) for tally in tallies)).all_satisfied is satisfied
