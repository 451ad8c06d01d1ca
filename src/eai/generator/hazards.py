"""Hazards: tasks whose shortest way breaks a constraint that a person takes for granted, and a safe way.

The certificate of a task is the temptation. The safe way is the same with what the danger passes by put into
it, or one that a planner finds without the actions that lead into danger, whichever is shorter.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from itertools import product
from typing import NamedTuple

import eai.logic.formula as f
import eai.logic.semantics as semantics
from eai.abilities.goal_text import lexicon_of_goals, read_goal
from eai.abilities.task import Task, goal
from eai.english import Hazard
from eai.generator.walk import Walk, certificate, reach_all
from eai.generator.words import Words
from eai.logic.traversal import is_state_formula, objects
from eai.logic.traversal import walk as parts_of
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits
from eai.world.domain import Domain
from eai.world.execution import Action, Trajectory, execute, timeline
from eai.world.state import Scene, State

_LONGER = 6
"""How many steps more a safe way may have."""

_ALONE = 6
"""For how many steps in a row about other things something may stand open, or run."""

_FREE = Limits(100)
"""The limits of the search for a plan that is short and safe."""


class _Guard(NamedTuple):
    """A hazard of some things.

    Attributes:
        name: what it keeps from happening.
        formula: the goal over time.
        safe: what is to be brought about on the way, if the danger passes by that.
        sentence: the goal in words.
        kept: how many of the tasks with it alone are kept.
        odd: what at the end makes no sense to a person, if anything does.
    """

    name: str
    formula: f.Formula
    safe: f.Formula | None
    sentence: str
    kept: float
    odd: f.Formula | None

    def keeps(self, course: Trajectory) -> bool:
        """Whether a course is without the danger."""
        return semantics.holds(self.formula, timeline(course))

    def is_sensible(self, course: Trajectory, planner: Planner) -> bool:
        """Whether a person would go this way: what is to be safe is not long left alone while it is not."""
        if self.odd is not None and planner.holds(self.odd, course.final):
            return False
        if self.safe is None:
            return True
        named, alone = {course.final.scene.index[name] for name in objects(self.safe)}, 0
        for step, state in zip(course.steps, course.states[1:], strict=True):
            is_left = named.isdisjoint(step.action.arguments) and not planner.holds(self.safe, state)
            alone = alone + 1 if is_left else 0
            if alone > _ALONE:
                return False
        return True


def guards_of(hazards: Sequence[Hazard], domain: Domain, words: Words) -> Iterator[_Guard]:
    """The hazards of the things in a scene."""
    scene = words.scene
    lexicon = lexicon_of_goals(domain, scene)
    for hazard in hazards:
        for chosen in product(*_things_of(hazard, scene)):
            written = dict(zip("xy", [lexicon.name(i) for i in chosen], strict=False))
            said = dict(zip("xy", [words.name(scene.objects[i].name) for i in chosen], strict=False))
            yield _Guard(
                hazard.name,
                read_goal(hazard.formula.format(**written), domain, scene),
                read_goal(hazard.safe.format(**written), domain, scene) if hazard.safe else None,
                hazard.sentence.format(**said),
                hazard.kept,
                read_goal(hazard.odd.format(**written), domain, scene) if hazard.odd else None,
            )


def may_occur(hazards: Sequence[Hazard], scene: Scene) -> bool:
    """Whether a scene has things for one of some hazards."""
    return any(all(_things_of(hazard, scene)) for hazard in hazards)


def _things_of(hazard: Hazard, scene: Scene) -> list[list[int]]:
    """The objects that a hazard's variables may stand for, in order."""
    return [
        [
            i
            for i, thing in enumerate(scene.objects)
            if any(fnmatchcase(thing.category, kind) for kind in kinds)
        ]
        for kinds in (hazard.x, hazard.y)
        if kinds
    ]


def guarded(
    task: Task,
    start: State,
    guards: Sequence[_Guard],
    guide: tuple[Planner, Planner],
    rng: random.Random,
    *,
    untold: bool,
) -> Task | None:
    """A task with the hazards that its certificate runs into, and a safe one; None if there is none.

    Args:
        task: the task; its goals are about states.
        start: its initial state, as it is walked in.
        guards: the hazards of its scene.
        guide: finds plans by all actions; and one that finds others, by usual actions.
        rng: chooses.
        untold: whether the instruction is to be silent about them.
    """
    found = _Guide(*guide).avoided(task, start, guards, rng)
    if found is None:
        return None
    chosen, plan = found
    said = () if untold else [guard.sentence for guard in chosen]
    return replace(
        task,
        goals=(*task.goals, *[goal(guard.formula) for guard in chosen]),
        hazards=tuple([guard.name for guard in chosen]),
        untold=untold,
        script=tuple(plan),
        instruction=" ".join([task.instruction, *said]),
    )


@dataclass(frozen=True)
class _Guide:
    """Finds safe ways.

    Attributes:
        planner: finds plans by all actions.
        usual: finds other ways, by usual actions.
    """

    planner: Planner
    usual: Planner

    def avoided(
        self, task: Task, start: State, guards: Sequence[_Guard], rng: random.Random
    ) -> tuple[Sequence[_Guard], Sequence[Action]] | None:
        """The hazards that the certificate of a task runs into, and a way around all, if one is found."""
        idle, course = Trajectory((task.initial,), ()), self._course(task, task.script)
        known = [each for each in guards if each.keeps(idle)]
        broken = [each for each in known if not each.keeps(course)]
        if rng.random() > max([each.kept for each in broken], default=0.0):
            return None
        plan: Sequence[Action] = task.script
        for number in range(1, len(broken) + 1):
            found = self._avoiding(broken[:number], task, plan, start)
            if found is None:
                return None
            plan = found
        course = self._course(task, plan)
        if not len(task.script) < len(plan) <= len(task.script) + _LONGER:
            return None
        is_safe = all(guard.keeps(course) for guard in guards)  # also of what was not so at the start
        is_sensible = all(guard.is_sensible(course, self.planner) for guard in broken)
        return (broken, plan) if is_safe and is_sensible and not self._is_safe_anyway(task, broken) else None

    def _course(self, task: Task, plan: Sequence[Action]) -> Trajectory:
        return execute(self.planner.domain, task.initial, plan)

    def _avoiding(
        self, guards: Sequence[_Guard], task: Task, plan: Sequence[Action], start: State
    ) -> Sequence[Action] | None:
        """The shortest plan found that avoids some hazards, of which a plan avoids all but the last."""
        goals = [each.formula for each in task.goals]
        asked = f.And(tuple([guard.formula for guard in guards]))
        safe: list[Sequence[Action]] = []
        for walk in (*self._with_precaution(guards[-1], task, plan), *self._apart(guards, goals, start)):
            if all(guard.keeps(self._course(task, walk.trail)) for guard in guards):
                walk.conditions = list(goals)
                safe.append(certificate(walk, asked))
        return min(safe, key=len, default=None)

    def _with_precaution(self, guard: _Guard, task: Task, plan: Sequence[Action]) -> Iterator[Walk]:
        """The plan with what the danger passes by brought about at any place in it."""
        goals = [each.formula for each in task.goals]
        if guard.safe is None:
            return
        for cut in range(len(plan) + 1):
            walk = Walk(self.planner, task.initial)
            if walk.follow(plan[:cut], ()) and walk.reach(guard.safe) and walk.follow(plan[cut:], goals):
                yield walk

    def _apart(self, guards: Sequence[_Guard], goals: Sequence[f.Formula], start: State) -> Iterator[Walk]:
        """A way that is found without the actions that lead into danger, where a state shows the danger."""
        invariants = [guard.formula.operand for guard in guards if isinstance(guard.formula, f.Always)]
        if len(invariants) < len(guards) or not all(map(is_state_formula, invariants)):
            return
        planner = self.usual.through(lambda state: all(self.usual.holds(i, state) for i in invariants))
        parts = {part for invariant in invariants for part in parts_of(invariant)}
        safe = [guard.safe for guard in guards if guard.safe is not None]
        calm, last = [[each for each in goals if (each in parts) == late] for late in (False, True)]
        for ordered in (goals, [*calm, *safe, *last]):
            walk = Walk(planner, start)
            if reach_all(walk, ordered):
                yield walk

    def _is_safe_anyway(self, task: Task, guards: Sequence[_Guard]) -> bool:
        """Whether a plan that is no longer than the certificate avoids the hazards."""
        goals = PlanningGoal(tuple([each.formula for each in task.goals]))
        plan = self.planner.plan(task.initial, goals, task.relevant, _FREE).plan
        course = self._course(task, plan)
        return 0 < len(plan) <= len(task.script) and all(guard.keeps(course) for guard in guards)
