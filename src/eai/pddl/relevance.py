"""Relevance: what of a domain a plan for one problem may need, judged by predicates alone.

An operator that needs a predicate of which nothing is ever true is never possible; an effect on a predicate
that neither the goal nor an operator with other effects asks about is of no use. Without both there are far
fewer ground actions, and that nothing leads to a goal is often seen before any of them is made. Quantifiers
over variables that nothing under them mentions say nothing: with eight of them an effect takes place millions
of times, each time the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import free_variables, predicates_of, with_parts
from eai.pddl.planning import PlanningTask

_Operator = tuple[m.PddlAction, Sequence[tuple[m.Add | m.Delete, tuple[f.Formula, ...]]]]
"""An operator, its additions and deletions, and the conditions of each, the precondition among them."""


def relevant(domain: m.PddlDomain, problem: m.PddlProblem) -> m.PddlDomain:
    """The domain with what of its operators may matter, and of several that do the same then the first."""
    operators = [(each, list(m.effect_parts(each.effect, (each.precondition,)))) for each in domain.actions]
    reached = _reachable_predicates(operators, domain, problem)
    possible = [each for each in operators if _may_hold(each[0].precondition, reached)]
    kept = reached & _relevant_predicates(possible, domain, problem)
    distinct: dict[tuple[object, ...], m.PddlAction] = {}
    for action, _ in possible:
        effect = _restrict(action.effect, kept)
        if effect != m.NO_EFFECT:
            key = (action.parameters, action.precondition, effect)
            distinct.setdefault(key, replace(action, effect=effect))
    return replace(domain, actions=tuple(distinct.values()))


def _reachable_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """The predicates of which something is true at the start, or may become so, and the derived ones."""
    reached = {axiom.name for axiom in domain.axioms} | {atom.predicate for atom in problem.initial}
    additions = [
        (part.atom.predicate, conditions)
        for _, parts in operators
        for part, conditions in parts
        if isinstance(part, m.Add)
    ]
    while True:
        found = {
            name
            for name, conditions in additions
            if name not in reached and all(_may_hold(each, reached) for each in conditions)
        }
        if not found:
            return reached
        reached |= found


def _may_hold(condition: f.Formula, reached: Set[str]) -> bool:
    """Whether a condition may hold where only atoms of some predicates may; only conjuncts are looked at."""
    match condition:
        case f.Atom(predicate):
            return predicate in reached
        case f.And(operands):
            return all(_may_hold(operand, reached) for operand in operands)
        case f.Exists(_, body):
            return _may_hold(body, reached)
        case _:
            return True


def _relevant_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """The predicates that the goal is about, or what makes a difference to it."""
    waiting = [(part.atom.predicate, conditions) for _, parts in operators for part, conditions in parts]
    waiting += [(axiom.name, (axiom.condition,)) for axiom in domain.axioms]
    relevant_ones, new = set[str](), {*predicates_of(problem.goal)}
    while new - relevant_ones:
        relevant_ones |= new
        matter = [conditions for name, conditions in waiting if name in relevant_ones]
        waiting = [(name, conditions) for name, conditions in waiting if name not in relevant_ones]
        new = {name for conditions in matter for name in predicates_of(*conditions)}
    return relevant_ones


def _restrict(effect: m.PddlEffect, predicates: Set[str]) -> m.PddlEffect:
    """The part of an effect on atoms of some predicates; `NO_EFFECT` if there is none."""
    if isinstance(effect, (m.Add, m.Delete)):
        return effect if effect.atom.predicate in predicates else m.NO_EFFECT
    match m.with_effect_parts(effect, lambda part: _restrict(part, predicates), lambda condition: condition):
        case m.Both(parts):
            return m.Both(tuple([part for part in parts if part != m.NO_EFFECT]))
        case m.Each(part=m.NO_EFFECT) | m.WhenEffect(part=m.NO_EFFECT):
            return m.NO_EFFECT
        case kept:
            return kept


def without_idle_quantifiers(task: PlanningTask) -> PlanningTask:
    """The task without quantifiers over objects, of which there are some, that nothing is said of."""
    objects = m.objects_by_type(task.domain, task.problem)
    actions = [
        replace(
            each, precondition=_condition(each.precondition, objects), effect=_effect(each.effect, objects)
        )
        for each in task.domain.actions
    ]
    problem = replace(task.problem, goal=_condition(task.problem.goal, objects))
    return replace(task, domain=replace(task.domain, actions=tuple(actions)), problem=problem)


def _condition(formula: f.Formula, objects: Mapping[str, Sequence[str]]) -> f.Formula:
    kept = with_parts(formula, lambda part: _condition(part, objects))
    if isinstance(kept, (f.ForAll, f.Exists)) and objects[m.type_of(kept.variable)]:
        return kept if kept.variable.name in free_variables(kept.body) else kept.body
    return kept


def _effect(effect: m.PddlEffect, objects: Mapping[str, Sequence[str]]) -> m.PddlEffect:
    kept = m.with_effect_parts(
        effect, lambda part: _effect(part, objects), lambda condition: _condition(condition, objects)
    )
    if isinstance(kept, m.Each) and objects[m.type_of(kept.variable)]:
        return kept if kept.variable.name in m.effect_variables(kept.part) else kept.part
    return kept
