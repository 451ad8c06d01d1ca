"""Quantifiers that say nothing: over variables that nothing under them mentions.

With eight of them an effect takes place millions of times, each time the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import free_variables
from eai.pddl.planning import PlanningTask


def without_idle_quantifiers(task: PlanningTask) -> PlanningTask:
    """The task without quantifiers over objects, of which there are some, that nothing is said of."""
    objects = m.objects_by_type(task.domain, task.problem)
    actions = tuple(
        [
            replace(
                action,
                precondition=_condition(action.precondition, objects),
                effect=_effect(action.effect, objects),
            )
            for action in task.domain.actions
        ]
    )
    problem = replace(task.problem, goal=_condition(task.problem.goal, objects))
    return replace(task, domain=replace(task.domain, actions=actions), problem=problem)


def _condition(formula: f.Formula, objects: Mapping[str, Sequence[str]]) -> f.Formula:
    match formula:
        case f.ForAll(variable, body) | f.Exists(variable, body):
            body = _condition(body, objects)
            is_idle = objects.get(m.type_of(variable)) and variable.name not in free_variables(body)
            return body if is_idle else type(formula)(variable, body)
        case f.Not(operand):
            return f.Not(_condition(operand, objects))
        case f.And(operands) | f.Or(operands):
            return type(formula)(tuple([_condition(each, objects) for each in operands]))
        case f.Implies(premise, conclusion):
            return f.Implies(_condition(premise, objects), _condition(conclusion, objects))
        case _:
            return formula


def _effect(effect: m.PddlEffect, objects: Mapping[str, Sequence[str]]) -> m.PddlEffect:
    match effect:
        case m.Each(variable, part):
            part = _effect(part, objects)
            is_idle = objects.get(m.type_of(variable)) and variable.name not in _free(part)
            return part if is_idle else m.Each(variable, part)
        case m.Both(parts):
            return m.Both(tuple([_effect(part, objects) for part in parts]))
        case m.WhenEffect(condition, part):
            return m.WhenEffect(_condition(condition, objects), _effect(part, objects))
        case _:
            return effect


def _free(effect: m.PddlEffect) -> frozenset[str]:
    """The names of the variables that no quantifier of an effect binds."""
    match effect:
        case m.AddEffect(atom) | m.DeleteEffect(atom):
            return free_variables(atom)
        case m.Each(variable, part):
            return _free(part) - {variable.name}
        case m.Both(parts):
            return frozenset[str]().union(*map(_free, parts))
        case m.WhenEffect(condition, part):
            return free_variables(condition) | _free(part)
