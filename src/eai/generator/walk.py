"""A walk through a scene that reaches one goal after the other, and the certificate that is left of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import eai.logic.formula as f
import eai.logic.semantics as semantics
from eai.abilities.goal_test import GoalTest
from eai.abilities.task import GoalKind, Task, goal
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits, Node, SearchEnd
from eai.planning.successor_generator import PlanNode, SuccessorGenerator, applicable_actions
from eai.world.domain import Domain
from eai.world.execution import Action, Step, Trajectory, execute
from eai.world.state import State
from eai.world.timeline import timeline

_FOR_A_GOAL = Limits(20, thorough=False)
"""The limits of the search for reaching one goal more."""

_FOR_ALL = Limits(300)
"""The limits of the search for finding a shorter plan for all goals than the walk was."""

_LONG = 25
"""From how many steps on that is tried."""


@dataclass
class Walk:
    """Goes on from goal to goal.

    Attributes:
        planner: finds the way, by actions that are usual.
        state: where the walk is.
        start: where it began.
        conditions: the goals about states that hold here and are to last.
        actions: the action goals, in the order in which they were met.
        goals: all of them, in the order in which they were reached.
        trail: all actions so far.
    """

    domain: Domain
    planner: Planner
    state: State
    start: State = field(init=False)
    conditions: list[f.Formula] = field(default_factory=list)
    actions: list[tuple[str, ...]] = field(default_factory=list)
    goals: list[f.Formula] = field(default_factory=list)
    trail: list[Action] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.start = self.state

    @property
    def objects(self) -> tuple[int, ...]:
        """The objects of actions: all there are."""
        return tuple(range(len(self.state.scene.objects)))

    def mark(self) -> tuple[State, int, int, int, int]:
        """Where the walk is, to come back to."""
        return self.state, len(self.conditions), len(self.actions), len(self.goals), len(self.trail)

    def back_to(self, mark: tuple[State, int, int, int, int]) -> None:
        """Forget all that came after a mark."""
        self.state, conditions, actions, goals, trail = mark
        del self.conditions[conditions:], self.actions[actions:], self.goals[goals:], self.trail[trail:]

    def holds(self, wanted: f.Formula, state: State) -> bool:
        """Whether a goal about states is met; one about actions never is."""
        return not _actions_of(wanted) and self.planner.holds(wanted, state)

    def reach(self, wanted: f.Formula) -> bool:
        """Go on until one goal more is met, if a way is found."""
        names = _actions_of(wanted)
        if names:
            asked = PlanningGoal(tuple(self.conditions), (names,))
        elif self.holds(wanted, self.state):
            return False
        else:
            asked = PlanningGoal((*self.conditions, wanted))
        found = self.planner.plan(self.state, asked, self.objects, _FOR_A_GOAL)
        if found.end is not SearchEnd.SOLVED:
            return False
        for action in found.plan:
            compiled = self.domain.compiled[action.operator]
            self.state = compiled.apply(self.state, compiled.bind(self.state, action.arguments))
        self.trail += found.plan
        self.goals.append(wanted)
        if names:
            self.actions.append(names)
        else:
            self.conditions.append(wanted)
        return True

    def follow(self, plan: Sequence[Action], goals: Sequence[f.Formula]) -> bool:
        """Go on by a plan, if that leads to some goals about states."""
        course = execute(self.domain, self.state, plan)
        if course.failure is not None or not all(self.holds(goal, course.final) for goal in goals):
            return False
        self.state = course.final
        self.trail += plan
        self.goals += goals
        self.conditions += goals
        return True


def _actions_of(wanted: f.Formula) -> tuple[str, ...]:
    """The actions one of which a goal asks for; none if it is about states."""
    parts = wanted.operands if isinstance(wanted, f.Or) else (wanted,)
    return tuple([part.action for part in parts if isinstance(part, f.Occurs)])


def certificate(walk: Walk, over_time: f.Formula | None = None) -> Sequence[Action]:
    """What is left of a walk without needless steps, or a shorter plan that the planner finds for all goals.

    The planner is asked where the walk was long; a short one it follows step by step. It knows nothing of
    goals over time.
    """
    asked = PlanningGoal(tuple(walk.conditions), tuple(walk.actions))
    walked = _without_needless(walk, asked, over_time)
    if len(walked) < _LONG or over_time is not None:
        return walked
    found = walk.planner.plan(walk.start, asked, walk.objects, _FOR_ALL).plan
    return found if 0 < len(found) < len(walked) else walked


def steps_of_planner(walk: Walk) -> int | None:
    """How many steps the plan has that the planner finds for all goals at once; None if it finds none."""
    asked = PlanningGoal(tuple(walk.conditions), tuple(walk.actions))
    return len(walk.planner.plan(walk.start, asked, walk.objects, _FOR_ALL).plan) or None


def _without_needless(walk: Walk, asked: PlanningGoal, over_time: f.Formula | None) -> Sequence[Action]:
    successors = SuccessorGenerator(walk.domain, lambda action, state: (action,), walk.objects, asked.actions)
    start: PlanNode = Node(walk.start)
    end = start
    for action in walk.trail:
        end = successors.successor(end, action) or end

    def reached(node: PlanNode) -> bool:
        holds = walk.planner.holds
        if node.met < len(asked.actions) or not all(holds(c, node.state) for c in asked.conditions):
            return False
        return over_time is None or semantics.holds(over_time, timeline(_course(node)))

    return successors.without_needless(start, end, reached).plan()


def _course(node: PlanNode) -> Trajectory:
    """The way to a node."""
    steps = [Step(action, None) for action in node.plan()]
    return Trajectory(tuple([each.state for each in node.way()]), tuple(steps))


def lower_bound(task: Task, domain: Domain, depth: int) -> int:
    """How many actions a plan has at least: all that are shorter, up to this depth, were tried.

    It is the length of a shortest plan if that is not longer than the depth, and else the depth and one.
    """
    test, at_the_end = GoalTest(task), GoalTest(task.at_the_end)
    objects = range(len(task.scene.objects))
    nodes: list[PlanNode] = [Node(task.initial)]
    seen = {task.initial}
    forgetful = not test.watches and not task.goals_of(GoalKind.ACTION)
    for length in range(1, depth + 1):
        nodes, parents = [], nodes
        for parent in parents:
            for action, after in _successors(domain, parent.state, objects):
                node = Node(after, depth=length, parent=parent, actions=(action,))
                operators = [each.operator for each in node.plan()]
                if all(at_the_end.reached(after, operators)) and (
                    not test.watches or all(test.reached(after, operators, _course(node)))
                ):
                    return length
                if not (forgetful and after in seen):
                    seen.add(after)
                    nodes.append(node)
    return depth + 1


def _successors(domain: Domain, state: State, objects: Sequence[int]) -> Iterator[tuple[Action, State]]:
    """Every possible action with the state after it."""
    for operator in domain.operators:
        compiled = domain.compiled[operator.name]
        for action in applicable_actions(domain, operator, state, objects):
            yield action, compiled.apply(state, compiled.bind(state, action.arguments))


def posed(
    task_id: str, instruction: str, initial: State, goals: Sequence[f.Formula], plan: Sequence[Action]
) -> Task:
    """The task, about all objects of its scene."""
    return Task(
        id=task_id,
        title=task_id,
        instruction=instruction,
        initial=initial,
        goals=tuple(map(goal, goals)),
        relevant=tuple(range(len(initial.scene.objects))),
        script=tuple(plan),
    )
