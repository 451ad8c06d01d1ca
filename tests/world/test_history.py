from __future__ import annotations

from eai.world.history import History
from eai.world.state import State
from world import toy

ROBOT, HALL, SHED, RED, BLUE, LAMP = range(6)


def lit(*numbers: int) -> History:
    """Return a history of six states, in some of which, given by number, the lamp is on."""
    scene = toy.initial().scene
    history: History | None = None
    for number in range(6):
        history = History(scene.state([("lit", (LAMP,))] if number in numbers else []), history)
    assert history is not None
    return history


class Look:
    """Tests whether the lamp is on, and counts the tests."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self, state: State) -> bool:
        self.times += 1
        return state.has("lit", LAMP)


def test_a_history_has_its_states_in_order() -> None:
    initial = toy.initial()
    history = History(initial).extend(initial.scene.state([]))
    assert (history.number, history.states) == (1, (initial, history.state))
    assert history.before is not None
    assert history.before.states == (initial,)


def test_the_last_matching_state_is_returned() -> None:
    assert lit(1, 3).find_last_state_index("?", Look()) == 3
    assert lit(5).find_last_state_index("?", Look()) == 5
    assert lit(0).find_last_state_index("?", Look()) == 0
    assert lit().find_last_state_index("?", Look()) is None


def test_an_answered_question_tests_no_state_again() -> None:
    for numbers, found in (((), None), ((0,), 0)):
        history, look = lit(*numbers), Look()
        assert history.find_last_state_index("?", look) == found
        assert look.times == 6
        ways = [history.extend(history.states[-1]) for _ in range(2)]  # with equal beginnings
        assert [way.find_last_state_index("?", look) for way in ways] == [found, found]
        assert look.times == 8
        assert ways[0].find_last_state_index("another", look) == found
        assert look.times == 15


def test_a_very_long_history_is_freed_without_recursion() -> None:
    state = toy.initial()
    history = History(state)
    for _ in range(200_000):
        history = history.extend(state)
    assert len(history.states) == 200_001
    del history
