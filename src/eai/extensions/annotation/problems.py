"""Planning problems for the goals of tasks.

A problem requires some ground conditions of a task's goal, drawn at random until a planner can reach them.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

from eai.benchmarks.benchmark import Benchmark
from eai.logic.choice import count_dnf_terms, generate_dnf_terms
from eai.logic.formula import Formula
from eai.logic.traversal import find_object_names
from eai.pddl.export import ProblemToExport, export_problems
from eai.pddl.model import PddlDomain
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlanningTask
from eai.pddl.reader import read_action, read_problem
from eai.pddl.writer import write_domain, write_problem
from eai.planning.role import find_holding_and_location_predicates
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.relation import iterate_bits

MAX_DRAWS = 20
"""Maximum number of random choices of goal conditions that are tried to make a problem from a task."""

_MAX_LISTED_OPTIONS = 10_000
"""Maximum number of ways to meet a goal from which one is drawn at random.

The ways have a fixed order; those after this number are never drawn.
"""


@dataclass(frozen=True, slots=True)
class SampledProblem:
    """A planning problem made from a task.

    Attributes:
        task_id: the id of the task.
        domain: the planning domain with its operators, in PDDL.
        text: the problem, in PDDL.
        outcome: the planner's outcome.
        draws: number of times that conditions of the goal were drawn at random; the last draw was used.
        source: the parts of the task from which the problem was exported to PDDL; None if the data set
            provides the problem.
    """

    task_id: str
    domain: str
    text: str
    outcome: PlannerOutcome
    draws: int
    source: ProblemToExport | None


def make_problem(
    task: Task,
    benchmark: Benchmark,
    planner: PddlPlanner,
    *,
    operators: PddlDomain | None,
    conditions: int,
    seed: int,
) -> SampledProblem | None:
    """Return a planning problem whose goal consists of random ground conditions of a task's goal.

    If the task's goal can be met in several ways, one way is drawn, and then some of its conditions. If the
    planner cannot reach these conditions, everything is drawn again. If all draws fail, the last problem is
    returned with its outcome. The result is None if the task's goal has no conditions.

    Args:
        task: the task with its goal and initial state.
        benchmark: the benchmark of the task.
        planner: the planner that solves the problem.
        operators: the data set's planning domain with all its operators, or None if its problems use no such
            domain.
        conditions: maximum number of conditions in the goal of the problem.
        seed: seed of the draws. Equal seeds give equal problems.
    """
    made = None
    for attempt in range(MAX_DRAWS):
        goals = sample_goal_conditions(task, conditions, random.Random(f"{seed} {task.id} {attempt}"))  # noqa: S311
        if not goals:
            return None
        source: ProblemToExport | None = None
        if benchmark.data.problem_of is not None and operators is not None:
            domain, problem = operators, read_problem(benchmark.data.problem_of(task, goals))
        else:
            source = ProblemToExport(
                task.id, task.initial, goals, _find_relevant_object_bits(task, goals, benchmark.domain)
            )
            exported = export_problems(benchmark.domain, (source,))[0]
            domain, problem = exported.domain, exported.problem
        outcome = planner.solve(PlanningTask(domain, problem)).outcome
        made = SampledProblem(
            task.id, write_domain(domain), write_problem(problem), outcome, attempt + 1, source
        )
        if outcome is PlannerOutcome.SOLVED:
            break
    return made


def sample_goal_conditions(task: Task, max_count: int, rng: random.Random) -> tuple[Formula, ...]:
    """Choose conditions that meet all goals about a task's final state, and draw at most `max_count` of them.

    If several sets of conditions meet the goals, one set is drawn at random.
    """
    objects = task.scene.names_of_category
    wanted = [goal.formula for goal in task.without_goals_over_time.goals if goal.kind is not GoalKind.ACTION]
    formulas: dict[Formula, None] = {}
    for formula in wanted:
        number = rng.randrange(min(count_dnf_terms(formula, objects), _MAX_LISTED_OPTIONS) or 1)
        formulas |= dict.fromkeys(next(islice(generate_dnf_terms(formula, objects), number, None), ()))
    return tuple(rng.sample(tuple(formulas), min(max_count, len(formulas))))


def make_domain_with_operators(operator_texts: Sequence[str], header: PddlDomain) -> PddlDomain:
    """Return the data set's planning domain with the given operators, which are parsed from PDDL."""
    return replace(header, actions=tuple(map(read_action, operator_texts)))


def replace_domains_by_common_domain(
    problems: Sequence[SampledProblem], benchmark: Benchmark
) -> list[SampledProblem]:
    """Return the problems with one common planning domain, which declares the categories of all objects.

    Problems that the data set provides have no ``source``. If all problems are such problems, they stay as
    they are.
    """
    sources = [problem.source for problem in problems if problem.source is not None]
    if not sources:
        return list(problems)
    together = export_problems(benchmark.domain, sources)
    return [
        replace(problem, domain=write_domain(exported.domain), text=write_problem(exported.problem))
        for problem, exported in zip(problems, together, strict=True)
    ]


def _find_relevant_object_bits(task: Task, goals: Sequence[Formula], domain: Domain) -> int:
    """Return a bit mask of the task's relevant objects, the goals' objects, and all their carriers."""
    scene, initial = task.scene, task.initial
    supports = [initial.relation(name) for name in find_holding_and_location_predicates(domain)[1]]
    pending = [*task.relevant, *[scene.index[name] for goal in goals for name in find_object_names(goal)]]
    mask = 0
    while pending:
        index = pending.pop()
        if not mask >> index & 1:
            mask |= 1 << index
            pending += [below for support in supports for below in iterate_bits(support.row(index))]
    return mask
