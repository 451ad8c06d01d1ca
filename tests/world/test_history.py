from __future__ import annotations

from eai.world.history import History
from eai.world.state import State
from world import toy

ROBOT, HALL, SHED, RED, BLUE, LAMP = range(6)


def lit(*numbers: int) -> History:
    """A past of six states, in those of these numbers with the lamp on."""
    scene = toy.initial().scene
    past: History | None = None
    for number in range(6):
        past = History(scene.state([("lit", (LAMP,))] if number in numbers else []), past)
    assert past is not None
    return past


class Look:
    """Whether the lamp is on, and how often that was looked at."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self, state: State) -> bool:
        self.times += 1
        return state.has("lit", LAMP)


def test_a_past_has_its_states_in_order() -> None:
    initial = toy.initial()
    past = History(initial).extended(initial.scene.state([]))
    assert (past.number, past.states) == (1, (initial, past.state))
    assert past.before is not None
    assert past.before.states == (initial,)


def test_the_latest_state_counts() -> None:
    assert lit(1, 3).last_where("?", Look()) == 3
    assert lit(5).last_where("?", Look()) == 5
    assert lit(0).last_where("?", Look()) == 0
    assert lit().last_where("?", Look()) is None


def test_what_was_asked_before_is_looked_at_no_more() -> None:
    for numbers, found in (((), None), ((0,), 0)):
        past, look = lit(*numbers), Look()
        assert past.last_where("?", look) == found
        assert look.times == 6
        ways = [past.extended(past.states[-1]) for _ in range(2)]  # that begin alike
        assert [way.last_where("?", look) for way in ways] == [found, found]
        assert look.times == 8
        assert ways[0].last_where("another", look) == found
        assert look.times == 15


def test_a_very_long_past_is_given_up_like_a_short_one() -> None:
    state = toy.initial()
    past = History(state)
    for _ in range(200_000):
        past = past.extended(state)
    assert len(past.states) == 200_001
    del past
