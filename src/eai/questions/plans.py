"""Questions about plans: what holds after one, what becomes of it, what it can do without."""

from __future__ import annotations

import random
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from eai.abilities.explanation import formula_text
from eai.questions.one_step import statements
from eai.questions.setting import Item, Setting, numbered, some, with_counterparts
from eai.world.execution import Action
from eai.world.state import State

_MOST_FACTS = 12
"""How many facts about one object are asked for."""

_TRIES = 12
"""How many changes of a plan are tried for one that comes to what is wanted."""

_CHOICES = 3
"""How many wrong answers stand beside a right one."""

_DETOURS = 3
"""How many actions that a plan can do without are put into it."""

_OWN = 0.75
"""How often these are by operators of the plan: so the operator does not tell what is needed."""


class Result(IntEnum):
    """The outcome of a plan."""

    WORKS = 0
    MISSES = 1
    FAILS = 2


def _wanted(number: int) -> Result:
    """The result that is asked for: half of the plans fail, as two of four choices name a step that does."""
    return (Result.WORKS, Result.FAILS, Result.MISSES, Result.FAILS)[number % 4]


class Outcome(NamedTuple):
    """The outcome of a plan, and why.

    Attributes:
        result: what it comes to.
        missed: the goals that do not hold at its end, by number from 1.
        step: the first step that is impossible, by its place in the plan.
        requirement: the first of its requirements that is not met, by number from 1.
    """

    result: Result
    missed: tuple[int, ...] = ()
    step: int = 0
    requirement: int = 0


def outcome(setting: Setting, start: State, plan: Sequence[Action], done: int = 0) -> Outcome:
    """The outcome of a plan from a state on, before which so many of its steps were taken."""
    states = _states_along(setting, start, plan[done:])
    place = done + len(states) - 1
    if place < len(plan):
        return Outcome(Result.FAILS, (), place, setting.failing(states[-1], plan[place])[0])
    missed = tuple([n for n, held in enumerate(setting.reached(states[-1]), 1) if not held])
    return Outcome(Result.MISSES, missed) if missed else Outcome(Result.WORKS)


def _states_along(setting: Setting, start: State, plan: Sequence[Action]) -> list[State]:
    """The state before each step up to the first that is impossible; if none is, also the last."""
    states = [start]
    for action in plan:
        after = setting.after(states[-1], action)
        if after is None:
            break
        states.append(after)
    return states


def state_tracking(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """The facts that hold after several actions; in open form, all about one object."""
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
    values = {
        "plan": numbered([setting.text_of(action) for action in plan]),
        "object": setting.scene.objects[thing].name,
    }
    answer = [setting.text_of(fact) for fact in about]
    return Item(states[0], _operators(plan), len(plan), right, wrong, answer, values=values)


def counterfactual(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """The outcome of a plan that works, once a step is left out, two are exchanged, or one is put in."""
    if not setting.works:
        return None
    for _ in range(_TRIES):
        variant = _variant(setting, rng)
        if variant is None:
            continue
        plan = [step.action for step in variant.steps]
        came_to = outcome(setting, setting.states[variant.place], plan, variant.place)
        if came_to.result is _wanted(number):
            shown = [setting.text_of(action) for action in setting.way]
            operators = _operators([*plan, *setting.way])
            values = {"plan": numbered(shown), "change": variant.change}
            return _of_plan(setting, rng, came_to, variant.steps, operators, values)
    return None


def validation(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Where a plan fails, and why; or whether it works."""
    if not setting.works:
        return None
    course = _with_detours(setting, rng)
    plan, came_to = course.plan, Outcome(Result.WORKS)
    if _wanted(number) is not Result.WORKS:
        for _ in range(_TRIES):
            place = rng.randrange(len(course.plan))
            plan = _corrupted(setting, course.plan, place, rng)
            came_to = outcome(setting, course.states[place], plan, place)
            if plan and came_to.result is _wanted(number):
                break
        else:
            return None
    values = {"plan": numbered([setting.text_of(action) for action in plan])}
    steps = [_Numbered(n, action) for n, action in enumerate(plan, 1)]
    return _of_plan(setting, rng, came_to, steps, _operators(plan), values)


def justification(setting: Setting, rng: random.Random, number: int) -> Item | None:
    """Which steps of a plan can be left out, each by itself."""
    if not setting.works:
        return None
    course = _with_detours(setting, rng)
    plan = course.plan
    needless = [
        place
        for place in range(len(plan))
        if outcome(setting, course.states[place], plan[place + 1 :]).result is Result.WORKS
    ]
    steps = [f"step {place + 1}" for place in range(len(plan))]
    operators = {step: action.operator for step, action in zip(steps, plan, strict=True)}
    right = [steps[place] for place in needless]
    wrong = [step for place, step in enumerate(steps) if place not in needless]
    return Item(
        setting.states[0],
        _operators(plan),
        len(plan),
        right,
        wrong,
        [str(place + 1) for place in needless],
        values={"plan": numbered([setting.text_of(action) for action in plan]), "goals": _goals(setting)},
        formulas=setting.goals,
        about={step: (operator,) for step, operator in operators.items()},
        yes_no=with_counterparts(right, wrong, operators.__getitem__),
    )


class _Numbered(NamedTuple):
    """A step with its number in the plan that is shown; 0 for one that is not in it."""

    number: int
    action: Action


class _Variant(NamedTuple):
    """A plan that is changed from a place on, and the change in words."""

    steps: list[_Numbered]
    place: int
    change: str


def _variant(setting: Setting, rng: random.Random) -> _Variant | None:
    steps = [_Numbered(n, action) for n, action in enumerate(setting.way, 1)]
    place = rng.randrange(len(steps))
    match rng.choice(("leave out", "exchange", "put in")):
        case "leave out" if len(steps) > 1:
            return _Variant(steps[:place] + steps[place + 1 :], place, f"step {place + 1} is left out")
        case "exchange" if place + 1 < len(steps):
            steps[place : place + 2] = reversed(steps[place : place + 2])
            return _Variant(steps, place, f"steps {place + 1} and {place + 2} change places")
        case "put in":
            action = setting.some_action(rng, setting.states[place], possible=True)
            if action is not None:
                steps.insert(place, _Numbered(0, action))
                change = f"just before step {place + 1}, {setting.text_of(action)} is carried out"
                return _Variant(steps, place, change)
    return None


def _of_plan(
    setting: Setting,
    rng: random.Random,
    came_to: Outcome,
    plan: Sequence[_Numbered],
    operators: set[str],
    values: dict[str, str],
) -> Item | None:
    """The item about a plan; none where what fails has no number.

    Whatever it comes to, the choices are that it works, that it misses a goal, that one of two steps fails.
    """
    failing = plan[came_to.step].number if came_to.result is Result.FAILS else 0
    if came_to.result is Result.FAILS and not failing:
        return None
    said = {
        Result.WORKS: "every step can be carried out, and all goals hold at the end",
        Result.MISSES: "every step can be carried out, but at the end not all goals hold",
    }
    fails = {
        step.number: f"step {step.number} is the first that cannot be carried out"
        for step in plan
        if step.number
    }
    right = fails[failing] if failing else said[came_to.result]
    answer: list[str] = ["works"]
    if came_to.result is Result.FAILS:
        answer = [f"step {failing}", f"requirement {came_to.requirement}"]
    elif came_to.missed:
        answer = [f"goal {n}" for n in came_to.missed]
    classes = [text for text in said.values() if text != right]
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
            **{text: (text,) for text in said.values()},
            **{fails[number]: (action.operator, "a step fails") for number, action in plan if number},
        },
    )


def _corrupted(setting: Setting, plan: Sequence[Action], place: int, rng: random.Random) -> list[Action]:
    """The plan without a step, with two exchanged, or with another object or operator at a place."""
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


class _Course(NamedTuple):
    """A plan that works, and the states along it."""

    plan: list[Action]
    states: list[State]


def _with_detours(setting: Setting, rng: random.Random) -> _Course:
    """The way with up to three further actions that do not keep it from working."""
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
    return _Course(plan, states)


def _operators(plan: Sequence[Action]) -> set[str]:
    return {action.operator for action in plan}


def _goals(setting: Setting) -> str:
    return numbered([formula_text(goal) for goal in setting.goals])
