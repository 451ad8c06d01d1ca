"""Whether a plan that was found with an answer's operators works with the gold ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from eai.abilities.transition_modeling.task import TransitionTask
from eai.pddl.execute import Executor, PlanFlaw, PlanStep
from eai.pddl.model import PddlAction


def plan_flaw(
    task: TransitionTask, written: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> PlanFlaw | None:
    """Why the gold operators cannot execute a plan from the start of the task to its goal; None if they can.

    Each parameter of a gold operator stands for the object that the step has for the parameter of that name;
    where the answer does not use all of the names, parameters correspond by position, and a step with
    another number of objects cannot be executed.

    Args:
        task: the task, which asks for the operators of the plan.
        written: the answer's operators by name.
        plan: the plan.
    """
    domain = replace(task.domain.header, actions=tuple(task.gold.values()))
    steps = [_gold_step(step, written[step.action], task.gold[step.action]) for step in plan]
    return Executor(domain, task.problem).flaw(steps)


def _gold_step(step: PlanStep, written: PddlAction, gold: PddlAction) -> PlanStep:
    """A step as the gold operator takes it."""
    objects = {
        parameter.name: name for parameter, name in zip(written.parameters, step.arguments, strict=True)
    }
    wanted = [parameter.name for parameter in gold.parameters]
    known = objects.keys() >= set(wanted)
    return PlanStep(gold.name, tuple([objects[name] for name in wanted]) if known else step.arguments)
