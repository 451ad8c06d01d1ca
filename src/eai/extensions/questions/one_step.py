"""Questions about one action: its effects, which action it was, whether it is possible, and why not."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence

from eai.extensions.questions.setting import Item, Setting, listed, some, with_counterparts
from eai.planning.search import Effort
from eai.planning.successor_generator import applicable_actions
from eai.world.action import Action
from eai.world.state import Fact, State

_CANDIDATES = 8
"""Number of actions that an applicability question lists; half of them are possible."""

_DRAWS = 20
"""Maximum number of random draws of a fact or an action."""

_MAX_BINDINGS = 200_000
"""Maximum number of parameter bindings that are tried to list all possible actions."""

_BINDINGS = 40
"""Number of random actions per operator that are searched for an unmet requirement."""

_LEAST = 0.5
"""Probability that the action with the fewest unmet requirements is chosen."""

_OWN = 0.2
"""Probability that an operator of the task's path is preferred to all other operators."""

_IDLE = 0.3
"""Probability that a question about an action without effect is kept."""

_CHOICES = 3
"""Number of wrong choices beside the right one."""


def forward(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which facts hold after an action; in open form, which facts it changes."""
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
    """Ask which single action makes a false fact true or a true fact false."""
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
    """Ask which single action made exactly the listed changes."""
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
    """Ask which of the listed actions are possible. Half of them are."""
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
    """Ask which requirements of an action are not met."""
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
    one = rng.choice(seen)  # all equally often, also rarely unmet ones
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
    """Draw facts that hold in the last of several states, and facts that do not.

    If possible, facts of both lists had the other value in an earlier state. So neither "nothing changed"
    nor "everything changed" separates true from false statements.
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
    """Draw facts that are not in the given set: each is a known fact with one object replaced."""
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
    """Draw a state of the path, an action possible in it, and the next state; None if no action was found.

    The action is the path's next step or a random action, with equal probability.
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
    """Make a question about the single action that leads to a right state.

    A right action can change all predicates in ``changed``, and ``is_right`` holds after it. All actions on
    all objects are tried; there is no question if they are too many. A wrong action shares its name or
    objects with a right one or with another wrong one. Some wrong actions are possible.
    """
    bindings, everything = Effort(_MAX_BINDINGS), range(len(setting.scene.objects))
    tried = [
        each
        for operator in setting.rules.operators
        if changed <= setting.rules.changed_predicates[operator.name]
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
        setting.rules.operator_names,
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
    """Draw possible and impossible actions, preferably by the same operators, which then reveal nothing."""
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
    """Draw different random actions; fewer than requested if not enough are found."""
    found: dict[Action, None] = {}
    for _ in range(2 * number):
        action = setting.some_action(rng, state, possible=possible)
        if action is not None:
            found[action] = None
        if len(found) == number:
            break
    return list(found)
