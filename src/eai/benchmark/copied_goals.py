"""A task's goal copied as a subgoal: an answer that decides nothing, as a baseline for subgoals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import eai.logic.formula as f
from eai.abilities.goal_test import alternatives
from eai.abilities.subgoal_decomposition.notation import SubgoalNotation
from eai.abilities.subgoal_decomposition.rewriting import substitute
from eai.abilities.task import GoalKind, Task
from eai.world.relation import bits
from eai.world.state import Scene


def copied_goal(task: Task, notation: SubgoalNotation) -> f.Formula:
    """The goal of a task as one subgoal: its actions in order, on any objects, then all it says of the end.

    Quantifiers are written out, since not every notation has them; of pairs the first that there are. Goals
    over time are left out.
    """
    lexicon = notation.lexicon(task.scene)
    arities = notation.domain.arities
    actions = [
        _joined(f.Or, [_on_anything(name, arities[name]) for name in alternatives(goal)])
        for goal in task.goals_of(GoalKind.ACTION)
    ]
    lasting = [
        _without_quantifiers(goal.formula, task.scene)
        for goal in task.at_the_end.goals
        if goal.kind is not GoalKind.ACTION
    ]
    at_the_end = [_joined(f.And, lasting)] if lasting else []
    return lexicon.worded(_joined(f.Then, [*actions, *at_the_end]))


def _joined(kind: type[f.And | f.Or | f.Then], parts: Sequence[f.Formula]) -> f.Formula:
    """Some formulas as one; a single one stays as it is."""
    return parts[0] if len(parts) == 1 else kind(tuple(parts))


def _on_anything(action: str, arity: int) -> f.Formula:
    """That an action is taken, whatever it is about."""
    variables = [f.Variable(f"x{i}") for i in range(arity)]
    formula: f.Formula = f.Occurs(action, tuple(variables))
    for variable in reversed(variables):
        formula = f.Exists(variable, formula)
    return formula


def _without_quantifiers(formula: f.Formula, scene: Scene) -> f.Formula:
    """A formula that makes one with quantifiers true, written out for the objects of a scene."""

    def objects(variable: f.Variable) -> list[f.Constant]:
        return [f.Constant(scene.objects[i].name) for i in bits(scene.category(variable.category))]

    def each(variable: f.Variable, body: f.Formula, of: Iterable[f.Constant]) -> list[f.Formula]:
        name = f.Variable(variable.name)
        return [_without_quantifiers(substitute(body, {name: value}), scene) for value in of]

    match formula:
        case f.And(parts) | f.Or(parts):
            return _joined(type(formula), [_without_quantifiers(part, scene) for part in parts])
        case f.Not(operand):
            return f.Not(_without_quantifiers(operand, scene))
        case f.ForAll(variable, body):
            return _joined(f.And, each(variable, body, objects(variable)))
        case f.Exists(variable, body):
            return _joined(f.Or, each(variable, body, objects(variable)))
        case f.Exactly(count, variable, body):
            return _joined(f.And, each(variable, body, objects(variable)[:count]))
        case f.ForPairs(first, second, body, count):
            pairs = zip(objects(first), objects(second), strict=False)
            one = f.Variable(first.name)
            chosen = [each(second, substitute(body, {one: x}), [y])[0] for x, y in pairs]
            return _joined(f.And, chosen[:count])
        case _:
            return formula
