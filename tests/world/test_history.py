from __future__ import annotations

from eai.world.history import Past
from eai.world.state import State
from world import toy

ROBOT, HALL, SHED, RED, BLUE, LAMP = range(6)


def lit(*numbers: int) -> Past:
    """A past of six states, in those of these numbers with the lamp on."""
    scene = toy.initial().scene
    past: Past | None = None
    for number in range(6):
        past = Past(scene.state([("lit", (LAMP,))] if number in numbers else []), past)
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
    past = Past(initial).then(initial.scene.state([]))
    assert (past.number, past.states) == (1, (initial, past.state))
    assert past.before is not None
    assert past.before.states == (initial,)


def test_the_latest_state_counts() -> None:
    assert lit(1, 3).latest("?", Look()) == 3
    assert lit(5).latest("?", Look()) == 5
    assert lit(0).latest("?", Look()) == 0
    assert lit().latest("?", Look()) is None


def test_what_was_asked_before_is_looked_at_no_more() -> None:
    for numbers, found in (((), None), ((0,), 0)):
        past, look = lit(*numbers), Look()
        assert past.latest("?", look) == found
        assert look.times == 6
        ways = [past.then(past.states[-1]) for _ in range(2)]  # that begin alike
        assert [way.latest("?", look) for way in ways] == [found, found]
        assert look.times == 8
        assert ways[0].latest("another", look) == found
        assert look.times == 15


def test_a_very_long_past_is_given_up_like_a_short_one() -> None:
    state = toy.initial()
    past = Past(state)
    for _ in range(200_000):
        past = past.then(state)
    assert len(past.states) == 200_001
    del past
