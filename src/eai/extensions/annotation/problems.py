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
"""How often conditions are drawn for a task before it is given up."""

_LISTED = 10_000
"""Of more ways to meet a goal the first so many are drawn from."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A planning problem made of a task.

    Attributes:
        task_id: the task.
        domain: the planning domain with its operators.
        text: the problem.
        outcome: what a planner made of it.
        draws: how many were drawn before it was kept, or given up.
        source: what it was exported from; None where the data set poses its problems.
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
    """A problem about at most so many ground conditions of one way to meet the goal; None if it has none.

    What a planner cannot solve is drawn again; where nothing can be solved the last draw is returned with
    its outcome.

    Args:
        task: whose goal and initial state.
        benchmark: of the task.
        planner: what solves it.
        operators: the published planning domain with all its operators, if problems are of one.
        conditions: the most conditions.
        seed: of the draws; the same seed gives the same problem.
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
    """Some conditions of a way to meet the goals of a task about its end, drawn at random."""
    objects = task.scene.names_of_category
    wanted = [goal.formula for goal in task.at_the_end.goals if goal.kind is not GoalKind.ACTION]
    found: dict[Formula, None] = {}
    for formula in wanted:
        number = dice.randrange(min(count_options(formula, objects), _LISTED) or 1)
        found |= dict.fromkeys(next(islice(options(formula, objects), number, None), ()))
    return tuple(dice.sample(tuple(found), min(conditions, len(found))))


def domain_of(operators: Sequence[str], header: PddlDomain) -> PddlDomain:
    """A published planning domain with the texts of its operators read."""
    return replace(header, actions=tuple(map(read_action, operators)))


def with_one_domain(problems: Sequence[Problem], benchmark: Benchmark) -> list[Problem]:
    """The same problems, those that were exported of one domain, with the categories of all their objects."""
    sources = [each.source for each in problems if each.source is not None]
    if not sources:
        return list(problems)
    together = export_problems(benchmark.domain, sources)
    return [
        replace(each, domain=write_domain(exported.domain), text=write_problem(exported.problem))
        for each, exported in zip(problems, together, strict=True)
    ]


def _concerned(task: Task, goals: Sequence[Formula], domain: Domain) -> int:
    """The objects that a task is about, those that its goals name, and what these are in or on: a mask."""
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
