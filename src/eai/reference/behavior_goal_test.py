"""Which goals of a BEHAVIOR task hold, as eai-eval 1.0.5 finds out.

A goal holds if one of the ground options does that bddl keeps, where a thing is inside its direct container
only (``evolving_graph.py`` get_state_dict).

bddl looks at some of all options, by two caps deep inside (``bddl/utils.py``,
``bddl/condition_evaluation.py``): where quantifiers multiply options, only the first 20 index vectors in
order of their sum are tried, counting also those that do not exist; a pairing keeps one side in its order
(the generator of the other side's orders is used up after that) and tries the first 10 orders of the other.
So options are missing, and plans that reach one of them are judged to fail.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, combinations, islice, permutations, product
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.goal_test import GoalTest
from eai.abilities.task import Task
from eai.errors import InputError
from eai.households.behavior import predicates as p
from eai.logic.choice import Objects, Option, value_of
from eai.logic.formula import And, Atom, Formula, Not, Or
from eai.world.state import Scene

MAX_VECTORS = 20
MAX_PERMUTATIONS = 10

_Binding: TypeAlias = Mapping[str, str]


def truncated_options(formula: f.Formula, objects: Objects) -> list[Option]:
    """The options of a closed BDDL condition in the reference's order, with its omissions.

    Raises:
        InputError: a variable is not bound, or the formula is not one of BDDL's.
    """
    return _Truncation(objects).options(formula, {})


class _Truncation:
    def __init__(self, objects: Objects) -> None:
        self._objects = objects

    def options(self, formula: f.Formula, binding: _Binding) -> list[Option]:
        match formula:
            case f.Atom(predicate, arguments):
                return [(f.Atom(predicate, tuple(value_of(term, binding) for term in arguments)),)]
            case f.And(operands):
                return _joined(product(*[self.options(operand, binding) for operand in operands]))
            case f.Or(operands):
                return [option for operand in operands for option in self.options(operand, binding)]
            case f.Not(operand):
                return _negated(self.options(operand, binding))
            case f.Implies(premise, conclusion):
                return _negated(self.options(premise, binding)) + self.options(conclusion, binding)
            case f.ForAll(variable, body):
                return _joined(_first_vectors(self._instances(variable, body, binding)))
            case f.Exists(variable, body):
                return list(chain.from_iterable(self._instances(variable, body, binding)))
            case f.Exactly(count, variable, body):
                vectors = _first_vectors(self._instances(variable, body, binding))
                chosen = (combinations(vector, count) for vector in vectors if count <= len(vector))
                return _joined(chain.from_iterable(chosen))
            case f.ForPairs():
                return self._pairs(formula, binding)
            case _:
                raise InputError(f"BDDL has no {type(formula).__name__}")

    def _instances(self, variable: f.Variable, body: f.Formula, binding: _Binding) -> list[list[Option]]:
        values = self._objects(variable.category)
        return [self.options(body, {**binding, variable.name: value}) for value in values]

    def _pairs(self, formula: f.ForPairs, binding: _Binding) -> list[Option]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)
        cells = [
            [self.options(body, {**binding, first.name: x, second.name: y}) for y in columns if x != y]
            for x in rows
        ]
        height, width = len(cells), len(cells[0]) if cells else 0
        small, large = sorted((height, width))
        count = small if formula.count is None else formula.count
        fixed = tuple(range(count))
        if formula.count is not None or height < width:
            orders = [(fixed, order) for order in _first_orders(width, count)]
        else:
            orders = [(order, fixed) for order in _first_orders(large, count)]
        return [
            option
            for down, across in orders
            for option in _joined(_first_vectors([cells[i][j] for i, j in zip(down, across, strict=True)]))
        ]


def _joined(vectors: Iterable[Sequence[Option]]) -> list[Option]:
    return [tuple(chain.from_iterable(vector)) for vector in vectors]


def _negated(found: Sequence[Option]) -> list[Option]:
    """One negated condition of each option, in all combinations."""
    return [
        tuple(choice) for choice in product(*[[f.Not(condition) for condition in option] for option in found])
    ]


def _first_orders(size: int, length: int) -> Iterator[tuple[int, ...]]:
    return islice(permutations(range(size), length), MAX_PERMUTATIONS)


def _first_vectors(sequences: Sequence[Sequence[Option]]) -> Iterator[tuple[Option, ...]]:
    """The product of the sequences, as far as the first `MAX_VECTORS` index vectors go.

    Vectors come by their sum, then lexicographically; the last one of all comes last if the cap allows, and
    others of that sum never do. A vector that points outside a sequence uses up one of the cap.
    """
    highest = [len(sequence) - 1 for sequence in sequences]
    if any(last < 0 for last in highest):
        return
    by_sum = chain.from_iterable(_vectors(total, len(sequences)) for total in range(sum(highest)))
    tried = list(islice(by_sum, MAX_VECTORS))
    if len(tried) < MAX_VECTORS:
        tried.append(tuple(highest))
    for vector in tried:
        if all(index <= last for index, last in zip(vector, highest, strict=True)):
            yield tuple(sequence[index] for sequence, index in zip(sequences, vector, strict=True))


def _vectors(total: int, length: int) -> Iterator[tuple[int, ...]]:
    """All vectors of natural numbers with this sum, in lexicographic order."""
    if length == 1:
        yield (total,)
        return
    for head in range(total + 1):
        for tail in _vectors(total - head, length - 1):
            yield (head, *tail)


_IN_REFERENCE: Mapping[str, str] = {"inside": p.directly_inside.name}


def behavior_goal_test(task: Task) -> GoalTest:
    """The reference's test of a task's goals; they count by the kinds of their own formulas."""
    return GoalTest(task, [_asked(goal.formula, task.scene) for goal in task.goals])


def _asked(formula: Formula, scene: Scene) -> Formula:
    """What the reference asks in a goal's place: that all literals of one of its truncated options hold."""
    options = truncated_options(formula, scene.named)
    return Or(tuple([And(tuple([_literal(part) for part in option])) for option in options]))


def _literal(literal: Formula) -> Formula:
    """A literal as the reference sees it."""
    if isinstance(literal, Not):
        return Not(_literal(literal.operand))
    if not isinstance(literal, Atom):
        raise TypeError(f"{literal} is no condition of BDDL")
    return replace(literal, predicate=_IN_REFERENCE.get(literal.predicate, literal.predicate))
