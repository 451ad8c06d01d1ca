"""Questions about one action: what it changes, which one it was, which are possible, and why not."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence

from eai.extensions.questions.setting import Item, Setting, listed, some, with_counterparts
from eai.planning.search import Effort
from eai.planning.successor_generator import applicable_actions
from eai.world.action import Action
from eai.world.state import Fact, State

_CANDIDATES = 8
"""How many actions are to be distinguished where some of them are possible."""

_DRAWS = 20
"""How often a fact is drawn that never held."""

_MAX_BINDINGS = 200_000
"""Maximum number of values of parameters that are tried to list all possible actions."""

_BINDINGS = 40
"""How many actions by one operator are looked at for one with a requirement that is not met."""

_LEAST = 0.5
"""How often this is the one of them with the fewest such requirements."""

_OWN = 0.2
"""How often each operator of the way is preferred to those that are not of it."""

_IDLE = 0.3
"""How often an action is asked about that changes nothing."""

_CHOICES = 3
"""How many wrong answers stand beside a right one."""


def forward(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """The facts that hold after an action; in open form, those that are different."""
    moment = _moment(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    changes = setting.changes(state, after)
    if not changes and rng.random() > _IDLE:
        return None
    right, wrong = statements(setting, rng, [state, after])
    return Item(
        state, {action.operator}, 1, right, wrong, changes, values={"action": setting.text_of(action)}
    )


def backward(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which single action makes something true that is not."""
    moment = _moment(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    added, removed = setting.added(state, after), setting.added(after, state)
    if not added and not removed:
        return None
    fact = rng.choice([*added, *removed])
    literal = setting.text_of(fact) if fact in added else f"not {setting.text_of(fact)}"

    def is_right(reached: State) -> bool:
        return reached.has(fact.predicate, *fact.arguments) is (fact in added)

    values = {"fact": literal}
    return _which_action(setting, rng, state, action, {fact.predicate}, is_right, values)


def inverse(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which single action made these changes, and no others."""
    moment = _moment(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    changed = {fact.predicate for fact in (*setting.added(state, after), *setting.added(after, state))}
    if not changed:
        return None
    values = {"changes": listed(setting.changes(state, after))}
    return _which_action(
        setting, rng, state, action, changed, lambda reached: setting.alike(reached, after), values
    )


def applicability(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which actions are possible; half of those to choose from are."""
    state = rng.choice(setting.states)
    right, wrong = _alternatives(setting, rng, state, _CANDIDATES // 2)
    if len(right) < _CANDIDATES // 2 or len(wrong) < _CANDIDATES // 2:
        return None
    together = rng.sample([*right, *wrong], _CANDIDATES)
    answer = setting.texts(right)
    return Item(
        state,
        {action.operator for action in together},
        1,
        answer,
        setting.texts(wrong),
        answer,
        values={"actions": listed(setting.texts(together))},
        actions=True,
    )


def why_not(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which requirements of an action are not met."""
    state = rng.choice(setting.states)
    shown = [
        each for each in setting.rules.operators if len(each.checks) > 1 and each.arity <= len(setting.things)
    ]
    if not shown:
        return None
    own = {step.operator for step in setting.way}
    operator = rng.choice([each for each in shown if each.name in own and rng.random() < _OWN] or shown)
    drawn = [step for step in setting.way if step.operator == operator.name]
    drawn += [
        Action(operator.name, tuple(rng.sample(setting.things, operator.arity))) for _ in range(_BINDINGS)
    ]
    unmet = {each: setting.failing(state, each) for each in drawn}
    seen = sorted({n for each in unmet.values() for n in each})
    if not seen:
        return None
    one = rng.choice(seen)  # each as often as any other, also what seldom is not met
    fitting = [each for each in drawn if one in unmet[each]]
    least = min(fitting, key=lambda each: len(unmet[each]))
    action = least if rng.random() < _LEAST else rng.choice(fitting)
    failing = unmet[action]
    numbers = range(1, len(operator.checks) + 1)
    reasons, met = [f"requirement {n}" for n in numbers], [n for n in numbers if n not in failing]
    return Item(
        state,
        {action.operator},
        1,
        [reasons[n - 1] for n in sorted(failing, key=lambda n: n != one)],
        [reasons[n - 1] for n in sorted(met, key=lambda n: n not in seen)],
        [str(n) for n in failing],
        values={"action": setting.text_of(action)},
        about={reason: (f"{action.operator} {reason}", reason) for reason in reasons},
        yes_no={reasons[n - 1] for n in seen if any(n not in each for each in unmet.values())},
    )


def statements(setting: Setting, rng: random.Random, states: Sequence[State]) -> tuple[list[str], list[str]]:
    """Facts that hold in the last of some states, and facts that do not.

    Of each, as many as can be had were otherwise in one of the states before: so neither "as it was" nor
    "something has changed" tells them apart.
    """
    start, last = frozenset(setting.facts(states[0])), states[-1]
    gained = frozenset([fact for state in states[1:] for fact in setting.added(states[0], state)])
    lost = frozenset([fact for state in states[1:] for fact in setting.added(state, states[0])])
    ever, always = start | gained, start - lost
    now = start.difference(setting.added(last, states[0])).union(setting.added(states[0], last))
    right = [*some(rng, sorted(now - always), 2), *some(rng, sorted(always), 2)]
    wrong = some(rng, sorted(ever - now), 2)
    wrong += never_true(setting, rng, ever, max(2, _CHOICES - len(wrong)))
    return setting.texts(right), setting.texts(wrong)


def never_true(setting: Setting, rng: random.Random, ever: frozenset[Fact], number: int) -> list[Fact]:
    """Facts that are none of these: such as are, about another object."""
    found: list[Fact] = []
    known, things = sorted(ever), range(len(setting.scene.objects))
    for _ in range(_DRAWS if known else 0):
        predicate, arguments = rng.choice(known)
        changed = list(arguments)
        if changed:
            changed[rng.randrange(len(changed))] = rng.choice(things)
        fact = Fact(predicate, tuple(changed))
        if fact not in ever and len(set(changed)) == len(changed) and fact not in found:
            found.append(fact)
    return found[:number]


def _moment(setting: Setting, rng: random.Random) -> tuple[State, Action, State] | None:
    """A state of the way, an action that is possible in it, and the state after it; None if none is found.

    The action is the next of the way, or any, equally often.
    """
    step = rng.randrange(len(setting.states))
    state = setting.states[step]
    if step < len(setting.way) and rng.random() < 0.5:
        return state, setting.way[step], setting.states[step + 1]
    action = setting.some_action(rng, state, possible=True)
    after = None if action is None else setting.after(state, action)
    return None if action is None or after is None else (state, action, after)


def _which_action(
    setting: Setting,
    rng: random.Random,
    state: State,
    action: Action,
    changed: set[str],
    is_right: Callable[[State], bool],
    values: Mapping[str, str],
) -> Item | None:
    """Which action changes these predicates, among others, so that the state after it is right.

    All actions on all objects are tried; if they are too many, there is no question. Wrong ones look like a
    right one, or like each other, and some are possible.
    """
    bindings, everything = Effort(_MAX_BINDINGS), range(len(setting.scene.objects))
    tried = [
        each
        for operator in setting.rules.operators
        if changed <= setting.rules.written[operator.name]
        for each in applicable_actions(setting.domain, operator, state, everything, bindings)
    ]
    if bindings.is_exceeded:
        return None
    right = [each for each in tried if (after := setting.after(state, each)) is not None and is_right(after)]
    number = len(action.arguments)
    alike = [operator.name for operator in setting.rules.operators if operator.arity == number]
    drawn: list[Action] = []
    for _ in range(_CANDIDATES):
        name, things = rng.choice(alike), tuple(rng.sample(setting.things, number))
        drawn += [Action(name, action.arguments), Action(action.operator, things), Action(name, things)]
    drawn += _drawn(setting, rng, state, _CHOICES, possible=True)
    reached = {each: setting.after(state, each) for each in drawn}
    wrong = setting.texts([each for each, after in reached.items() if after is None or not is_right(after)])
    answer = setting.texts(right)
    return Item(
        state,
        setting.rules.names,
        1,
        answer,
        wrong,
        answer,
        "any",
        values,
        actions=True,
        yes_no=with_counterparts(answer, wrong, lambda text: text.partition("(")[0]),
    )


def _alternatives(
    setting: Setting, rng: random.Random, state: State, number: int
) -> tuple[list[Action], list[Action]]:
    """Possible actions and impossible ones, where it can be by the same operators: no name gives one away."""
    right: list[Action] = []
    wrong: list[Action] = []
    for operator in rng.sample(setting.rules.operators, len(setting.rules.operators)):
        if len(right) == number or operator.arity > len(setting.things):
            continue
        possible = other = None
        for _ in range(_DRAWS):
            action = Action(operator.name, tuple(rng.sample(setting.things, operator.arity)))
            if setting.after(state, action) is None:
                other = other or action
            else:
                possible = possible or action
            if possible and other:
                break
        if possible is not None and other is not None:
            right.append(possible)
            wrong.append(other)
    right += _drawn(setting, rng, state, number - len(right), possible=True)
    wrong += _drawn(setting, rng, state, number - len(wrong), possible=False)
    return list(dict.fromkeys(right)), list(dict.fromkeys(wrong))


def _drawn(
    setting: Setting, rng: random.Random, state: State, number: int, *, possible: bool
) -> list[Action]:
    """Different actions drawn at random, fewer where there are not so many."""
    found: dict[Action, None] = {}
    for _ in range(2 * number):
        action = setting.some_action(rng, state, possible=possible)
        if action is not None:
            found[action] = None
        if len(found) == number:
            break
    return list(found)
