"""Planning problems: some ground conditions of a task's goal, drawn so that a planner can reach them."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

from eai.benchmarks.benchmark import Benchmark
from eai.logic.choice import count_options, options
from eai.logic.formula import Formula
from eai.logic.traversal import object_names
from eai.pddl.export import ProblemSource, export_problems
from eai.pddl.model import PddlDomain
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlanningTask
from eai.pddl.reader import read_action, read_problem
from eai.pddl.writer import write_domain, write_problem
from eai.planning.role import spatial_predicates
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.relation import bits

DRAWS = 20
"""Maximum number of draws of conditions for a task."""

_LISTED = 10_000
"""Maximum number of ways to meet a goal that conditions are drawn from: the first ones."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A planning problem made from a task.

    Attributes:
        task_id: the id of the task.
        domain: the planning domain with its operators, in PDDL.
        text: the problem, in PDDL.
        outcome: the planner's outcome.
        draws: number of draws until the problem was solved or given up.
        source: the task content that was exported; None if the data set provides its problems.
    """

    task_id: str
    domain: str
    text: str
    outcome: PlannerOutcome
    draws: int
    source: ProblemSource | None


def make_problem(
    task: Task,
    benchmark: Benchmark,
    planner: PddlPlanner,
    *,
    operators: PddlDomain | None,
    conditions: int,
    seed: int,
) -> Problem | None:
    """Draw at most ``conditions`` ground conditions of one way to meet a task's goal; None if it has none.

    Conditions that the planner cannot reach are drawn again. If all draws fail, the last one is returned with
    its outcome.

    Args:
        task: the task with its goal and initial state.
        benchmark: the benchmark of the task.
        planner: the planner that solves the problem.
        operators: the published planning domain with all its operators, if problems use one.
        conditions: maximum number of conditions.
        seed: seed of the draws; the same seed gives the same problem.
    """
    made = None
    for attempt in range(DRAWS):
        goals = draw(task, conditions, random.Random(f"{seed} {task.id} {attempt}"))  # noqa: S311
        if not goals:
            return None
        source: ProblemSource | None = None
        if benchmark.data.problem_of is not None and operators is not None:
            domain, problem = operators, read_problem(benchmark.data.problem_of(task, goals))
        else:
            source = ProblemSource(task.id, task.initial, goals, _concerned(task, goals, benchmark.domain))
            exported = export_problems(benchmark.domain, (source,))[0]
            domain, problem = exported.domain, exported.problem
        outcome = planner.solve(PlanningTask(domain, problem)).outcome
        made = Problem(task.id, write_domain(domain), write_problem(problem), outcome, attempt + 1, source)
        if outcome is PlannerOutcome.SOLVED:
            break
    return made


def draw(task: Task, conditions: int, dice: random.Random) -> tuple[Formula, ...]:
    """Draw conditions of a random way to meet a task's goals for the final state."""
    objects = task.scene.names_of_category
    wanted = [goal.formula for goal in task.without_goals_over_time.goals if goal.kind is not GoalKind.ACTION]
    found: dict[Formula, None] = {}
    for formula in wanted:
        number = dice.randrange(min(count_options(formula, objects), _LISTED) or 1)
        found |= dict.fromkeys(next(islice(options(formula, objects), number, None), ()))
    return tuple(dice.sample(tuple(found), min(conditions, len(found))))


def domain_of(operators: Sequence[str], header: PddlDomain) -> PddlDomain:
    """Return a published planning domain with its operators parsed."""
    return replace(header, actions=tuple(map(read_action, operators)))


def with_one_domain(problems: Sequence[Problem], benchmark: Benchmark) -> list[Problem]:
    """Return the problems; exported ones share one domain with the categories of all their objects."""
    sources = [each.source for each in problems if each.source is not None]
    if not sources:
        return list(problems)
    together = export_problems(benchmark.domain, sources)
    return [
        replace(each, domain=write_domain(exported.domain), text=write_problem(exported.problem))
        for each, exported in zip(problems, together, strict=True)
    ]


def _concerned(task: Task, goals: Sequence[Formula], domain: Domain) -> int:
    """Return the mask of the relevant objects, the goals' objects, and all objects that they are in or on."""
    scene, initial = task.scene, task.initial
    supports = [initial.relation(name) for name in spatial_predicates(domain)[1]]
    pending = [*task.relevant, *[scene.index[name] for goal in goals for name in object_names(goal)]]
    found = 0
    while pending:
        index = pending.pop()
        if not found >> index & 1:
            found |= 1 << index
            pending += [below for support in supports for below in bits(support.row(index))]
    return found
