"""Small random PDDL worlds with all of their states, to compare planning with.

The worlds have constants (one is named like a variable), `either` types, derived predicates (one of them
recursive), equality, quantified conditions, and nested conditional and universal effects.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from itertools import product
from pathlib import Path
from random import Random
from typing import TypeAlias

import eai.logic.formula as f
from eai.pddl.declaration import ConvertedPddlDomain
from eai.pddl.execute import PddlPlanExecutor, PddlState, PlanStep
from eai.pddl.files import read_domain_text, read_problem_text
from eai.pddl.model import get_variable_type, group_objects_by_type
from eai.planning.repair.edits import PlanSteps
from eai.tasks.task import Task, goal
from eai.world.action import Action

TYPES = {"spot": "spot", "lamp": "tool", "key": "tool"}
"""The types of objects, each with its supertype."""

OBJECTS = {"x": "spot", "home": "spot", "k": "key", "l": "lamp"}
"""The constants of a domain with their types; the first has the name of a variable."""

VARIABLE_TYPES = ("spot", "tool", "key", "object", "(either spot key)", "(either lamp spot)")
"""The types of parameters and quantified variables."""

PREDICATES = {
    "on": ("spot",),
    "held": ("tool",),
    "busy": (),
    "near": ("object", "object"),
    "road": ("spot",) * 2,
}
"""The stored predicates with the types of their arguments; `road` never changes."""

DERIVED = {"lit": ("object",), "linked": ("object", "object"), "done": ()}

Scope: TypeAlias = Mapping[str, str]
"""The types of variables by their names."""

MAX_STATES = 100
"""Maximum number of states of a world."""


class Writer:
    """Writes random conditions and effects.

    Args:
        random: the random generator.
    """

    def __init__(self, random: Random) -> None:
        self.random = random

    def atom(self, scope: Scope, names: Sequence[str]) -> str:
        """Return an atom of one of some predicates, with variables and constants of fitting types."""
        name = self.random.choice(names)
        types = {**PREDICATES, **DERIVED}[name]
        return f"({' '.join([name, *[self.term(scope, each) for each in types]])})"

    def term(self, scope: Scope, wanted: str) -> str:
        variables = [f"?{name}" for name, kind in scope.items() if fits(kind, wanted)]
        if variables and self.random.random() < 0.7:
            return self.random.choice(variables)
        return self.random.choice([name for name, kind in OBJECTS.items() if fits(kind, wanted)])

    def condition(self, scope: Scope, depth: int = 2, names: Sequence[str] = ()) -> str:
        """Return a condition about the variables of a scope; ``names`` are the allowed predicates."""
        names = names or [*PREDICATES, *DERIVED]
        kind = self.random.choice(("atom", "atom", "atom", "not", "equal", *COMPOUND * (depth > 0)))
        atom = self.atom(scope, names)
        match kind:
            case "atom":
                return atom
            case "not":
                return f"(not {atom})"
            case "equal":
                equality = f"(= {self.term(scope, 'object')} {self.term(scope, 'object')})"
                return self.random.choice((equality, f"(not {equality})"))
            case "exists" | "forall":
                name, over = self.variable(scope)
                body = self.condition({**scope, name: over}, depth - 1, names)
                return f"({kind} (?{name} - {over}) {body})"
            case _:
                parts = [self.condition(scope, depth - 1, names) for _ in range(2)]
                return f"({kind} {' '.join(parts)})"

    def variable(self, scope: Scope) -> tuple[str, str]:
        """Return a new variable, which seldom hides another one, and its type."""
        hides = scope and self.random.random() < 0.05
        name = self.random.choice([*scope]) if hides else f"v{len(scope)}"
        return name, self.random.choice(VARIABLE_TYPES)

    def effect(self, scope: Scope, depth: int = 2) -> str:
        changing = [name for name in PREDICATES if name != "road"]
        kind = self.random.choice(("add", "add", "delete", *("when", "forall", "and") * (depth > 0)))
        atom = self.atom(scope, changing)
        match kind:
            case "add":
                return atom
            case "delete":
                return f"(not {atom})"
            case "when":
                return f"(when {self.condition(scope, 1)} {self.effect(scope, depth - 1)})"
            case "and":
                return f"(and {self.effect(scope, depth - 1)} {self.effect(scope, depth - 1)})"
            case _:
                name, over = self.variable(scope)
                return f"(forall (?{name} - {over}) {self.effect({**scope, name: over}, depth - 1)})"


COMPOUND = ("and", "or", "imply", "exists", "forall")


def fits(kind: str, wanted: str) -> bool:
    """Whether all objects of a type belong to another type."""
    kinds = kind.removeprefix("(either ").removesuffix(")").split()
    return wanted == "object" or all(wanted in (each, TYPES.get(each)) for each in kinds)


@dataclass(frozen=True)
class Texts:
    """A world as lists of texts, which are joined to a domain and a problem.

    Attributes:
        actions: the parameters, conditions and effects of each action.
    """

    axioms: tuple[str, ...]
    actions: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...]
    initial: tuple[str, ...]
    goals: tuple[str, ...]

    @property
    def domain(self) -> str:
        """The file of the domain."""
        declared = " ".join(
            f"({' '.join([name, *[f'?a{i} - {kind}' for i, kind in enumerate(types)]])})"
            for name, types in {**PREDICATES, **DERIVED}.items()
        )
        actions = "\n".join(
            f"(:action act{number} :parameters ({parameters}) :precondition (and {' '.join(conditions)})"
            f" :effect (and {' '.join(effects)}))"
            for number, (parameters, conditions, effects) in enumerate(self.actions)
        )
        constants = " ".join(f"{name} - {kind}" for name, kind in OBJECTS.items())
        axioms = "\n".join(self.axioms)
        return (
            "(define (domain random) (:requirements :adl :derived-predicates)"
            " (:types spot tool - object lamp key - tool)\n"
            f"(:constants {constants})\n(:predicates {declared})\n{axioms}\n{actions})"
        )

    @property
    def problem(self) -> str:
        """The file of the problem."""
        return (
            "(define (problem p) (:domain random) (:objects b - spot)"
            f" (:init {' '.join(self.initial)}) (:goal (and {' '.join(self.goals)})))"
        )


def write_world(random: Random) -> Texts:
    """Return a random world; every state meets its goal."""
    writer = Writer(random)
    stored = [*PREDICATES]
    pair = {"a0": "object", "a1": "object"}
    axioms = (
        f"(:derived (lit ?a0 - object) {writer.condition({'a0': 'object'}, 2, stored)})",
        f"(:derived (linked ?a0 - object ?a1 - object) {writer.condition(pair, 1, stored)})",
        "(:derived (linked ?a0 - object ?a1 - object)"
        f" (exists (?z - object) (and (near ?a0 ?z) ({random.choice(('linked', 'near'))} ?z ?a1))))",
        f"(:derived (done) {writer.condition({}, 2, [*stored, 'lit'])})",
    )
    actions = tuple([write_action(writer) for _ in range(random.randint(2, 5))])
    facts = [
        f"({' '.join([name, *chosen])})"
        for name, types in PREDICATES.items()
        for chosen in [[random.choice(objects_of(kind)) for kind in types] for _ in range(2 if types else 1)]
        if random.random() < 0.6
    ]
    return Texts(axioms, actions, tuple(dict.fromkeys(facts)), ())


def objects_of(kind: str) -> list[str]:
    """Return the objects of a type."""
    return [name for name, own in {**OBJECTS, "b": "spot"}.items() if fits(own, kind)]


def write_action(writer: Writer) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """Return the parameters, conditions and effects of a random action, which often ends its conditions."""
    random = writer.random
    scope = {"xyz"[i]: random.choice(VARIABLE_TYPES) for i in range(random.choice((0, 1, 1, 2)))}
    conditions = [writer.condition(scope, 1) for _ in range(random.choice((0, 0, 1)))]
    effects = [writer.effect(scope) for _ in range(random.randint(1, 3))]
    if random.random() < 0.7:
        needed = writer.atom(scope, ["on", "held", "busy", "near"])
        conditions.append(needed)
        effects += [f"(not {needed})"] if random.random() < 0.7 else []
    return " ".join(f"?{name} - {kind}" for name, kind in scope.items()), tuple(conditions), tuple(effects)


class World:
    """A world with all of its states and their distances from the goal.

    States and steps are computed by `eai.pddl.execute`, which does not search.

    Attributes:
        source: the text of the domain.
        problem: the text of the problem.
        domain: the declared domain.
        task: the problem as a task.
        steps: the PDDL step of each action, impossible actions included.
        after: for each state, the state after each possible action.
        is_small: whether all reachable states were computed.
        distances: the number of actions from a state to the goal, for states from which it is reachable.
    """

    def __init__(self, texts: Texts) -> None:
        self.source = read_domain_text(texts.domain, Path("domain.pddl"))
        self._declaration = ConvertedPddlDomain(self.source)
        self.domain = self._declaration.domain
        self.aim_at(texts)
        index, members = self.task.scene.index, group_objects_by_type(self.source, self.problem)
        self.steps = {
            Action(each.name, tuple([index[name] for name in names])): PlanStep(each.name, names)
            for each in self.source.actions
            for names in product(*[members[get_variable_type(parameter)] for parameter in each.parameters])
        }
        self.after: dict[PddlState, dict[Action, PddlState]] = {}
        self.is_small = self._explore()

    def aim_at(self, texts: Texts) -> None:
        """Replace the goals of the world by those of some texts."""
        self.texts = texts
        self.problem = read_problem_text(texts.problem, Path("p.pddl"), self.source).problem
        initial, goals = self._declaration.convert_problem(self.problem)
        self.task = Task(
            id="p",
            title="p",
            instruction="p",
            initial=initial,
            goals=tuple(map(goal, dict.fromkeys(goals))),
            relevant=tuple(range(len(initial.scene.objects))),
        )
        self.executor = PddlPlanExecutor(self.source, self.problem)
        self.initial = self.executor.initial_state

    def choose_goals(self, random: Random) -> None:
        """Choose goals that hold in a state far from the start, or seldom any goals."""
        writer, wanted = Writer(random), random.choice([*self.after][-20:])
        proposed = [writer.condition({}, 1) for _ in range(30)]
        self.aim_at(replace(self.texts, goals=tuple(proposed)))
        assert isinstance(self.problem.goal, f.And)
        goals = []
        for text, formula in zip(proposed, self.problem.goal.operands, strict=True):
            is_new = not self.executor.holds(formula, self.initial, {})
            is_met = self.executor.holds(formula, wanted, {})
            if random.random() < 0.03 or (is_met and (is_new or random.random() < 0.1)):
                goals.append(text)
        self.aim_at(replace(self.texts, goals=tuple(goals[:3])))
        self.distances = self._distances()

    def _explore(self) -> bool:
        waiting = deque([self.initial])
        while waiting:
            state = waiting.popleft()
            if state in self.after:
                continue
            if len(self.after) >= MAX_STATES:
                return False
            self.after[state] = {
                action: after
                for action, step in self.steps.items()
                if not isinstance(after := self.executor.execute_step(state, step), str)
            }
            waiting.extend(self.after[state].values())
        return True

    def is_goal(self, state: PddlState) -> bool:
        """Whether the goal holds in a state."""
        return self.executor.holds(self.problem.goal, state, {})

    def _distances(self) -> dict[PddlState, int]:
        before: dict[PddlState, set[PddlState]] = {}
        for state, following in self.after.items():
            for after in following.values():
                before.setdefault(after, set()).add(state)
        found = {state: 0 for state in self.after if self.is_goal(state)}
        waiting = deque(found)
        while waiting:
            state = waiting.popleft()
            for earlier in before.get(state, ()):
                if earlier not in found:
                    found[earlier] = found[state] + 1
                    waiting.append(earlier)
        return found

    def end(self, plan: PlanSteps) -> PddlState | None:
        """Return the state after a plan, or None if one of its steps is impossible."""
        state: PddlState | None = self.initial
        for action in plan:
            state = None if state is None or action is None else self.after[state].get(action)
        return state

    def succeeds(self, plan: PlanSteps) -> bool:
        """Whether a plan is possible and ends in the goal."""
        state = self.end(plan)
        return state is not None and self.distances.get(state) == 0

    def edits(self, plan: PlanSteps) -> int | None:
        """Return the fewest edits after which a plan succeeds, or None: a shortest path by Dijkstra."""
        numbers = {state: number for number, state in enumerate(self.after)}
        states = [*self.after]
        queue, done = [(0, 0, 0)], set[tuple[int, int]]()
        while queue:
            cost, number, place = heappop(queue)
            if (number, place) in done:
                continue
            done.add((number, place))
            state = states[number]
            if place == len(plan) and self.distances.get(state) == 0:
                return cost
            following = self.after[state]
            left = place < len(plan)
            if left:
                heappush(queue, (cost + 1, number, place + 1))
                step = plan[place]
                if step is not None and step in following:
                    heappush(queue, (cost, numbers[following[step]], place + 1))
            for after in {*following.values()}:
                heappush(queue, (cost + 1, numbers[after], place))
                if left:
                    heappush(queue, (cost + 1, numbers[after], place + 1))
        return None


def worlds(random: Random) -> Iterator[World]:
    """Yield small random worlds; most have a goal that takes some actions."""
    while True:
        world = World(write_world(random))
        if world.is_small and len(world.after) > 3:
            for _ in range(8):
                world.choose_goals(random)
                if world.distances.get(world.initial, 0) > 1 or random.random() < 0.05:
                    yield world
                    break


def draw_plan(world: World, random: Random) -> tuple[Action | None, ...]:
    """Return a random walk from the initial state, with some steps changed."""
    state, plan = world.initial, list[Action | None]()
    for _ in range(random.randint(0, 4)):
        following = world.after[state]
        if not following:
            break
        action = random.choice([*following])
        plan.append(action)
        state = following[action]
    for _ in range(random.choice((0, 0, 1, 2))):
        place = random.randint(0, len(plan))
        plan[place : place + random.randint(0, 1)] = random.choice(
            ([], [random.choice([*world.steps])], [None])
        )
    return tuple(plan)
