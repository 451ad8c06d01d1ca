"""Questions about all ways that some actions open: what can be reached, how best, and by what in any case."""

from __future__ import annotations

import random
from collections.abc import Sequence

from eai.questions.one_step import never_true
from eai.questions.question import Accept
from eai.questions.rules import Repertoire, exhaust
from eai.questions.setting import Item, Setting, listed, numbered, some
from eai.world.state import Fact

_ACTIONS = 8
"""How many actions there are to take, at most."""

_LEAST_ACTIONS = 5
"""How many, at least."""

_STATES = 150
"""The most states that are exhausted; where the actions lead to more, nothing is asked."""

_REPERTOIRES = 4
"""How many choices of actions a task has, at most."""

_CANDIDATES = 4
"""How many facts of each kind are to be distinguished."""

_LEAST_DISTANCE = 2
"""How many actions a goal takes at least."""

_MOST_GOALS = 3
"""How many facts are to hold together, at most."""

_DISTANCES = 4
"""How many different distances are asked for in turn."""

_AIMS = 8
"""How many goals are tried for one of the distance that is asked for."""


def reachability(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which facts can become true by some actions, and which never do."""
    wider = _some_ways(setting, rng)
    if wider is None:
        return None
    narrower = wider.within(some(rng, range(len(wider.actions)), len(wider.actions) - 2))
    within = narrower.becoming_true
    beyond = wider.becoming_true - within
    right = [setting.text_of(fact) for fact in some(rng, sorted(within), _CANDIDATES)]
    ever = within.union(setting.facts(wider.states[0]))
    tempting = some(rng, sorted(beyond), _CANDIDATES)
    others = [fact for fact in never_true(setting, rng, ever, _CANDIDATES) if fact not in tempting]
    wrong = [setting.text_of(fact) for fact in [*tempting, *others][:_CANDIDATES]]
    if not right or not wrong:
        return None
    together = rng.sample([*right, *wrong], len(right) + len(wrong))
    values = {"actions": _action_list(setting, narrower), "facts": listed(together)}
    shown = {action.operator for action in narrower.actions}
    return Item(wider.states[0], shown, max(narrower.depths) or 1, right, wrong, right, values=values)


def next_action(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which action a shortest plan begins with."""
    aim = _some_aim(setting, rng, number)
    if aim is None:
        return None
    left = aim.ways.from_here(aim.is_reached)
    best = {edge.action for edge in aim.ways.edges[0] if left.get(edge.target) == aim.distance - 1}
    return _about_actions(setting, aim, sorted(best), Accept.ANY)


def landmarks(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which actions are in every plan."""
    aim = _some_aim(setting, rng, number)
    if aim is None:
        return None
    needed = [n for n in range(len(aim.ways.actions)) if aim.ways.distance(aim.is_reached, without=n) is None]
    return _about_actions(setting, aim, needed, Accept.ALL)


class _Aim:
    """A goal that some actions reach, not all at once.

    Attributes:
        ways: all that the actions lead to.
        facts: what shall hold together.
        distance: how many actions it takes at least.
    """

    def __init__(self, ways: Repertoire, facts: Sequence[Fact]) -> None:
        self.ways = ways
        self.facts = facts
        self._reached = [set(facts).issubset(gained) for gained in ways.gained]
        self.distance = ways.distance(self.is_reached) or 0

    def is_reached(self, number: int) -> bool:
        """Whether the goal holds in a state."""
        return self._reached[number]


def _some_aim(setting: Setting, rng: random.Random, number: int) -> _Aim | None:
    """A few facts that are new in a state that takes some actions to get to.

    Of those that are tried it is the one whose distance comes nearest to what the number asks for.
    """
    ways = _some_ways(setting, rng)
    if ways is None:
        return None
    wanted = _LEAST_DISTANCE + number % _DISTANCES
    far = [n for n, depth in enumerate(ways.depths) if depth >= _LEAST_DISTANCE]
    farther = [n for n in far if ways.depths[n] >= wanted]
    aims = [
        _Aim(ways, some(rng, ways.gained[n], rng.randint(1, _MOST_GOALS)))
        for n in some(rng, farther or far, _AIMS)
        if ways.gained[n]
    ]
    fitting = [aim for aim in aims if aim.distance >= _LEAST_DISTANCE]
    return min(fitting, key=lambda aim: abs(aim.distance - wanted), default=None)


def _some_ways(setting: Setting, rng: random.Random) -> Repertoire | None:
    """One of a few repertoires of a task, each of which is exhausted once, whatever is asked of it."""
    number = rng.randrange(_REPERTOIRES)
    if number not in setting.repertoires:
        dice = random.Random(f"{setting.seed} {number}")  # noqa: S311 - chance, not secrets
        setting.repertoires[number] = _drawn(setting, dice)
    return setting.repertoires[number]


def _drawn(setting: Setting, rng: random.Random) -> Repertoire | None:
    """All that a few actions lead to: some that follow each other on the way, and others."""
    first = rng.randrange(len(setting.way)) if setting.way else 0
    chosen = dict.fromkeys(setting.way[first : first + rng.randint(3, _ACTIONS - 2)])
    states = setting.states[first : first + len(chosen) + 1]
    for _ in range(2 * _ACTIONS):
        if len(chosen) >= _ACTIONS:
            break
        state = rng.choice(states)
        action = setting.some_action(rng, state, possible=True)
        if action is not None and setting.after(state, action) != state:
            chosen[action] = None
    if len(chosen) < _LEAST_ACTIONS:
        return None
    return exhaust(setting, states[0], rng.sample(list(chosen), len(chosen)), _STATES)


def _about_actions(setting: Setting, aim: _Aim, right: list[int], accept: Accept) -> Item:
    said = [setting.text_of(action) for action in aim.ways.actions]
    answer = [said[n] for n in right]
    return Item(
        aim.ways.states[0],
        {action.operator for action in aim.ways.actions},
        aim.distance,
        answer,
        [text for n, text in enumerate(said) if n not in right],
        answer,
        accept,
        {
            "actions": _action_list(setting, aim.ways),
            "goals": numbered([setting.text_of(fact) for fact in aim.facts]),
        },
    )


def _action_list(setting: Setting, ways: Repertoire) -> str:
    return listed([setting.text_of(action) for action in ways.actions])
