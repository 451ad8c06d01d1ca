"""An independent word on a plan for a task: VAL's, on the task as PDDL."""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.task import Task
from eai.pddl.export import ExportOptions, ProblemSource, export_problems
from eai.pddl.val import Val, ValVerdict
from eai.world.domain import Domain
from eai.world.execution import Action


def verdict_of_val(val: Val, domain: Domain, task: Task, plan: Sequence[Action]) -> ValVerdict:
    """What VAL says of a plan.

    Raises:
        DomainError: a goal is about more than the end, of which PDDL says nothing.
    """
    source = ProblemSource("task", task.initial, tuple([goal.formula for goal in task.goals]))
    (exported,) = export_problems(domain, [source], ExportOptions())
    return val.verdict(exported.domain, exported.problem, [exported.step(action) for action in plan])
