"""Questions about plans: their final state, their outcome, and their unneeded steps.

Reachability, next-action and landmark questions are about all plans that a few listed actions allow.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from eai.extensions.questions.one_step import never_true, statements
from eai.extensions.questions.question import Accept
from eai.extensions.questions.setting import (
    Item,
    Repertoire,
    Setting,
    exhaust,
    listed,
    numbered,
    some,
    with_counterparts,
)
from eai.tasks.goal_text import write_goal
from eai.world.action import Action
from eai.world.state import Fact, State

_MOST_FACTS = 12
"""Maximum number of facts about one object in an answer."""

_TRIES = 12
"""Maximum number of plan changes that are tried to get the wanted outcome."""

_CHOICES = 3
"""Number of wrong choices beside the right one."""

_DETOURS = 3
"""Maximum number of unneeded actions that are inserted into a plan."""

_OWN = 0.75
"""Probability that an inserted action uses an operator of the plan, so that its name reveals nothing."""

_WANTED = ("works", "fails", "misses", "fails")
"""Wanted outcomes, in turn. Half of the plans fail, as two of four choices name a failing step."""

_ACTIONS = 8
"""Maximum number of available actions in a question about all plans."""

_LEAST_ACTIONS = 5
"""Minimum number of available actions in a question about all plans."""

_STATES = 150
"""Maximum number of explored states. If the actions lead to more states, there is no question."""

_REPERTOIRES = 4
"""Maximum number of sets of available actions for each task."""

_CANDIDATES = 4
"""Maximum number of reachable facts and of unreachable facts in a question."""

_LEAST_DISTANCE = 2
"""Minimum number of actions of a shortest plan for a goal."""

_MOST_GOALS = 3
"""Maximum number of facts in a goal."""

_DISTANCES = 4
"""Number of different goal distances; questions take them in turn."""

_AIMS = 8
"""Number of goals that are tried to get the wanted distance."""

_Steps: TypeAlias = Sequence[tuple[int, Action]]
"""Steps of a changed plan, each with its number in the plan that the question shows; 0 for an added step."""


class _Outcome(NamedTuple):
    """The outcome of a plan.

    Attributes:
        missed: numbers, from 1, of the goals that do not hold at the end.
        step: 0-based position of the first impossible step.
        requirement: number, from 1, of that step's first unmet requirement; 0 if all steps are possible.
    """

    missed: tuple[int, ...] = ()
    step: int = 0
    requirement: int = 0

    @property
    def result(self) -> str:
        """Whether the plan works, misses a goal or fails at a step."""
        return "fails" if self.requirement else "misses" if self.missed else "works"


def _outcome_of(setting: Setting, start: State, plan: Sequence[Action], done: int = 0) -> _Outcome:
    """Return the outcome of a plan whose first `done` steps already led to the given state."""
    states = _states_along(setting, start, plan[done:])
    place = done + len(states) - 1
    if place < len(plan):
        return _Outcome((), place, setting.failing(states[-1], plan[place])[0])
    return _Outcome(tuple([n for n, held in enumerate(setting.reached(states[-1]), 1) if not held]))


def _states_along(setting: Setting, start: State, plan: Sequence[Action]) -> list[State]:
    """Return the state before each step up to the first impossible step, or up to the end."""
    states = [start]
    for action in plan:
        after = setting.after(states[-1], action)
        if after is None:
            break
        states.append(after)
    return states


def state_tracking(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which facts hold after several actions; in open form, for all facts about one object."""
    if not setting.way:
        return None
    first = rng.randrange(len(setting.way))
    last = rng.randrange(first + 1, len(setting.way) + 1)
    states, plan = setting.states[first : last + 1], setting.way[first:last]
    right, wrong = statements(setting, rng, states)
    thing = rng.choice([i for action in plan for i in action.arguments] or [0])
    about = [fact for fact in setting.facts(states[-1]) if thing in fact.arguments]
    if len(about) > _MOST_FACTS:
        return None
    values = {"plan": numbered(setting.texts(plan)), "object": setting.scene.objects[thing].name}
    return Item(states[0], _operators(plan), len(plan), right, wrong, setting.texts(about), values=values)


def counterfactual(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask for the outcome of a working plan after a step is omitted, added, or swapped with the next."""
    if not setting.works:
        return None
    for _ in range(_TRIES):
        variant = _variant(setting, rng)
        if variant is None:
            continue
        steps, place, change = variant
        plan = [action for _, action in steps]
        outcome = _outcome_of(setting, setting.states[place], plan, place)
        if outcome.result == _WANTED[number % len(_WANTED)]:
            operators = _operators([*plan, *setting.way])
            values = {"plan": numbered(setting.texts(setting.way)), "change": change}
            return _of_plan(setting, rng, outcome, steps, operators, values)
    return None


def validation(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask at which step a plan fails and why, or whether it works."""
    if not setting.works:
        return None
    sound, states = _with_detours(setting, rng)
    plan, outcome, wanted = sound, _Outcome(), _WANTED[number % len(_WANTED)]
    if wanted != outcome.result:
        for _ in range(_TRIES):
            place = rng.randrange(len(sound))
            plan = _corrupted(setting, sound, place, rng)
            outcome = _outcome_of(setting, states[place], plan, place)
            if plan and outcome.result == wanted:
                break
        else:
            return None
    values = {"plan": numbered(setting.texts(plan))}
    return _of_plan(setting, rng, outcome, list(enumerate(plan, 1)), _operators(plan), values)


def justification(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which single steps of a plan can be left out."""
    if not setting.works:
        return None
    plan, states = _with_detours(setting, rng)
    needless = [
        number
        for number, before in enumerate(states[:-1], 1)
        if _outcome_of(setting, before, plan[number:]).result == "works"
    ]
    operators = {f"step {number}": action.operator for number, action in enumerate(plan, 1)}
    right = [f"step {number}" for number in needless]
    wrong = [step for step in operators if step not in right]
    return Item(
        setting.states[0],
        _operators(plan),
        len(plan),
        right,
        wrong,
        list(map(str, needless)),
        values={"plan": numbered(setting.texts(plan)), "goals": _goals(setting)},
        formulas=setting.goals,
        about={step: (operator,) for step, operator in operators.items()},
        yes_no=with_counterparts(right, wrong, operators.__getitem__),
    )


def _variant(setting: Setting, rng: random.Random) -> tuple[_Steps, int, str] | None:
    """Change a plan at random; return its steps, the position of the change, and the change in words."""
    steps = list(enumerate(setting.way, 1))
    place = rng.randrange(len(steps))
    match rng.choice(("leave out", "exchange", "put in")):
        case "leave out" if len(steps) > 1:
            return steps[:place] + steps[place + 1 :], place, f"step {place + 1} is left out"
        case "exchange" if place + 1 < len(steps):
            steps[place : place + 2] = reversed(steps[place : place + 2])
            return steps, place, f"steps {place + 1} and {place + 2} change places"
        case "put in":
            action = setting.some_action(rng, setting.states[place], possible=True)
            if action is not None:
                steps.insert(place, (0, action))
                change = f"just before step {place + 1}, {setting.text_of(action)} is carried out"
                return steps, place, change
    return None


def _of_plan(
    setting: Setting,
    rng: random.Random,
    outcome: _Outcome,
    plan: _Steps,
    operators: set[str],
    values: Mapping[str, str],
) -> Item | None:
    """Make a question about the outcome of a plan; None if the failing step has no number.

    The choices are always the same: it works, it misses a goal, or one of two steps fails.
    """
    failing = plan[outcome.step][0] if outcome.requirement else 0
    if outcome.requirement and not failing:
        return None
    sentences = {
        "works": "every step can be carried out, and all goals hold at the end",
        "misses": "every step can be carried out, but at the end not all goals hold",
    }
    fails = {n: f"step {n} is the first that cannot be carried out" for n, _ in plan if n}
    right = fails[failing] if failing else sentences[outcome.result]
    answer = [f"goal {n}" for n in outcome.missed] or ["works"]
    if failing:
        answer = [f"step {failing}", f"requirement {outcome.requirement}"]
    classes = [text for text in sentences.values() if text != right]
    steps = [text for text in fails.values() if text != right]
    return Item(
        setting.states[0],
        operators,
        len(plan),
        [right],
        [*classes, *some(rng, steps, _CHOICES - len(classes))],
        answer,
        values={**values, "goals": _goals(setting)},
        formulas=setting.goals,
        about={
            **{text: (text,) for text in sentences.values()},
            **{fails[n]: (action.operator, "a step fails") for n, action in plan if n},
        },
    )


def _corrupted(setting: Setting, plan: Sequence[Action], place: int, rng: random.Random) -> list[Action]:
    """Remove a step, swap it with the next, or replace one of its objects or its operator."""
    action, corrupted = plan[place], list(plan)
    match rng.choice(("leave out", "exchange", "object", "operator")):
        case "leave out":
            del corrupted[place]
        case "exchange":
            corrupted[place : place + 2] = reversed(corrupted[place : place + 2])
        case "object" if action.arguments:
            changed = list(action.arguments)
            changed[rng.randrange(len(changed))] = rng.choice(setting.things)
            corrupted[place] = Action(action.operator, tuple(changed))
        case _:
            alike = [o.name for o in setting.rules.operators if o.arity == len(action.arguments)]
            corrupted[place] = Action(rng.choice(alike), action.arguments)
    return corrupted


def _with_detours(setting: Setting, rng: random.Random) -> tuple[list[Action], list[State]]:
    """Return the path with up to three unneeded actions inserted, and its states."""
    plan, states = list(setting.way), list(setting.states)
    length = len(plan) + rng.randint(0, _DETOURS)
    for _ in range(_TRIES):
        if len(plan) == length:
            break
        place = rng.randrange(len(plan) + 1)
        own = [step.operator for step in plan] if rng.random() < _OWN else ()
        action = setting.some_action(rng, states[place], possible=True, operators=own)
        if action is None:
            continue
        rest = [action, *plan[place:]]
        along = _states_along(setting, states[place], rest)
        if len(along) > len(rest) and all(setting.reached(along[-1])):
            plan[place:], states[place:] = rest, along
    return plan, states


def _operators(plan: Sequence[Action]) -> set[str]:
    return {action.operator for action in plan}


def _goals(setting: Setting) -> str:
    return numbered([write_goal(goal) for goal in setting.goals])


def reachability(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which facts the available actions can make true, and which never become true."""
    wider = _some_ways(setting, rng)
    if wider is None:
        return None
    narrower = wider.within(some(rng, range(len(wider.actions)), len(wider.actions) - 2))
    within = narrower.becoming_true
    beyond = wider.becoming_true - within
    right = setting.texts(some(rng, sorted(within), _CANDIDATES))
    ever = within.union(setting.facts(wider.states[0]))
    tempting = some(rng, sorted(beyond), _CANDIDATES)
    others = [fact for fact in never_true(setting, rng, ever, _CANDIDATES) if fact not in tempting]
    wrong = setting.texts([*tempting, *others][:_CANDIDATES])
    if not right or not wrong:
        return None
    together = rng.sample([*right, *wrong], len(right) + len(wrong))
    values = {"actions": listed(setting.texts(narrower.actions)), "facts": listed(together)}
    shown = _operators(narrower.actions)
    return Item(wider.states[0], shown, max(narrower.depths) or 1, right, wrong, right, values=values)


def next_action(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which action begins a shortest plan."""
    aim = _some_aim(setting, rng, number)
    if aim is None:
        return None
    left = aim.ways.distances_to(aim.reached)
    best = {action for action, target in aim.ways.edges[0] if left.get(target) == aim.distance - 1}
    return _about_actions(setting, aim, best, "any")


def landmarks(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Ask which actions every plan contains."""
    aim = _some_aim(setting, rng, number)
    if aim is None:
        return None
    numbers = range(len(aim.ways.actions))
    fewer = [aim.ways.within([other for other in numbers if other != n]) for n in numbers]
    needed = {n for n, ways in enumerate(fewer) if not any(map(aim.facts.issubset, ways.gained))}
    return _about_actions(setting, aim, needed, "all")


class _Aim:
    """A goal that takes several actions to reach.

    Attributes:
        ways: the available actions, and all states that they lead to.
        goals: the facts that must hold together.
        reached: numbers of the states that satisfy the goal, nearest first.
        distance: number of actions in a shortest plan.
    """

    def __init__(self, ways: Repertoire, goals: Sequence[Fact]) -> None:
        self.ways, self.goals, self.facts = ways, goals, frozenset(goals)
        self.reached = [n for n, gained in enumerate(ways.gained) if self.facts.issubset(gained)]
        self.distance = ways.depths[self.reached[0]]


def _some_aim(setting: Setting, rng: random.Random, number: int) -> _Aim | None:
    """Draw facts that become true together only after several actions.

    Several candidates are drawn. The result's distance is closest to the distance that `number` asks for.
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
    """Draw one of a task's few sets of available actions; return it with all states it leads to."""
    number = rng.randrange(_REPERTOIRES)
    if number not in setting.repertoires:
        dice = random.Random(f"{setting.seed} {number}")  # noqa: S311 - chance, not secrets
        setting.repertoires[number] = _drawn(setting, dice)
    return setting.repertoires[number]


def _drawn(setting: Setting, rng: random.Random) -> Repertoire | None:
    """Draw some available actions, from the path and others, and explore all states they lead to."""
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


def _about_actions(setting: Setting, aim: _Aim, right: set[int], accept: Accept) -> Item:
    texts = setting.texts(aim.ways.actions)
    answer = [text for n, text in enumerate(texts) if n in right]
    return Item(
        aim.ways.states[0],
        _operators(aim.ways.actions),
        aim.distance,
        answer,
        [text for n, text in enumerate(texts) if n not in right],
        answer,
        accept,
        {"actions": listed(texts), "goals": numbered(setting.texts(aim.goals))},
    )
