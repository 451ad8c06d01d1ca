from __future__ import annotations

import pytest

from eai.abilities.explanation import Explanation, GoalReport, StepReport
from eai.abilities.near_misses import near_misses


@pytest.mark.parametrize(
    ("added", "removed", "goal", "near"),
    [
        (("INSIDE(a, b)",), (), "ONTOP(a, b)", ("INSIDE(a, b)",)),
        (("ONTOP(a, c)",), (), "ONTOP(a, b)", ("ONTOP(a, c)",)),
        (("ONTOP(a, c)", "INSIDE(a, b)"), (), "ONTOP(a, b)", ("INSIDE(a, b)", "ONTOP(a, c)")),
        (("OPEN(a)",), (), "ON(a)", ()),
        (("NEXT_TO(a, b)", "NEXT_TO(b, a)"), (), "ONTOP(a, b)", ()),
        (("INSIDE(b, a)",), (), "ONTOP(a, b)", ()),
        (("INSIDE(c, b)",), (), "ONTOP(a, b)", ()),
        (("INSIDE(a, b)",), ("INSIDE(a, b)",), "ONTOP(a, b)", ()),
        (("INSIDE(a, b)",), (), "exists x. (ONTOP(a, x))", ()),
        (("INSIDE(a, b)",), (), "GRAB or TAKE", ()),
        ((), (), "ONTOP(a, b)", ()),
    ],
)
def test_a_near_miss_is_what_became_of_the_goals_objects(
    added: tuple[str, ...], removed: tuple[str, ...], goal: str, near: tuple[str, ...]
) -> None:
    steps = (StepReport("A()", "executed", added=added), StepReport("B()", "executed", removed=removed))
    missed = Explanation(steps=steps, goals=(GoalReport("relation", goal, False),))
    assert near_misses(missed) == ({goal: near} if near else {})


def test_a_state_is_a_near_miss_where_its_coming_ended_the_one_that_is_wanted() -> None:
    """What is opened is not what came of a thing that should be on, and neither is what is held."""
    steps = (
        StepReport("SWITCHOFF(a)", "executed", added=("OFF(a)",), removed=("ON(a)",)),
        StepReport("OPEN(a)", "executed", added=("OPEN(a)",), removed=("CLOSED(a)",)),
        StepReport("GRASP(a)", "executed", added=("in_right_hand(a)",)),
    )
    missed = Explanation(steps=steps, goals=(GoalReport("state", "ON(a)", False),))
    assert near_misses(missed) == {"ON(a)": ("OFF(a)",)}


def test_a_goal_that_is_reached_has_no_near_miss() -> None:
    steps = (StepReport("A()", "executed", added=("INSIDE(a, b)", "ONTOP(a, b)")),)
    assert near_misses(Explanation(steps=steps, goals=(GoalReport("relation", "ONTOP(a, b)", True),))) == {}
