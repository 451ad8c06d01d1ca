"""How a suite's prompts and answers name things: the words of a declaration, chosen for one ability."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import TypeAlias

from eai.abilities.explanation import formula_text
from eai.abilities.task import Task
from eai.logic.formula import Variable
from eai.logic.renaming import rename_objects
from eai.world.condition import Conditions
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.frame import Frame, Truth
from eai.world.operator import Check, Operator
from eai.world.vocabulary import Predicate, Vocabulary

ObjectName: TypeAlias = Callable[[Task, int], str]
"""What a prompt calls an object of a task."""

_MEANING = (
    (FaultKind.AFFORDANCE, "impossible where"),
    (FaultKind.MISSING_STEP, "not yet possible while"),
    (FaultKind.ADDITIONAL_STEP, "needless where"),
)
"""How a prompt says what the failure of a check means, in the order of the paper."""


def declared_name(task: Task, index: int) -> str:
    """The name of an object as its scene declares it."""
    return task.scene.objects[index].name


@dataclass(frozen=True)
class Wording:
    """The words of one suite.

    Attributes:
        domain: the declaration.
        predicates: what goals are made of: stored or derived predicates, by name.
        written_as: how answers name a predicate, where it is not its declared name.
        object_name: what objects are called.
    """

    domain: Domain
    predicates: tuple[str, ...]
    written_as: Mapping[str, str] = field(default_factory=dict)
    object_name: ObjectName = declared_name

    @staticmethod
    def of(domain: Domain) -> Wording:
        """The wording of any domain: every visible predicate that actions can change, every declared name."""
        changeable = [p.name for p in domain.vocabulary.predicates if p.visible and not p.static]
        return Wording(domain, tuple(changeable))

    def vocabulary(self) -> str:
        """What can be said of objects, one predicate with its parameters a line."""
        return _lines(
            f"{self._name(name)}({', '.join('xyz'[: self._arity(name)])})" for name in self.predicates
        )

    def operators(self) -> str:
        """The actions with their parameters, and what each of their checks means in words."""
        return _lines(_operator_text(operator) for operator in self.domain.operators)

    def objects(self, task: Task) -> str:
        """The objects of a task with their properties, each once."""
        properties = [p for p in self.domain.vocabulary.predicates if _is_property(p)]
        lines = []
        for index in _subjects(task):
            having = [p.name for p in properties if task.initial.has(p.name, index)]
            category = task.scene.objects[index].category
            lines.append(f"{self.object_name(task, index)} [{category}]: {', '.join(having) or '-'}")
        return _lines(dict.fromkeys(lines))

    def initial(self, task: Task) -> str:
        """What holds of a task's objects at the start."""
        facts = []
        for name in self.predicates:
            arity = self._arity(name)
            truth, frame = _truth(self.domain.vocabulary, name, arity)
            for arguments in permutations(_subjects(task), arity):
                if truth(task.initial, frame.bind(task.scene, arguments)):
                    names = ", ".join(self.object_name(task, i) for i in arguments)
                    facts.append(f"{self._name(name)}({names})")
        return _lines(dict.fromkeys(facts))

    def goals(self, task: Task) -> str:
        """The goals of a task."""
        names = {
            task.scene.objects[i].name: self.object_name(task, i) for i in range(len(task.scene.objects))
        }
        return _lines(formula_text(rename_objects(goal.formula, names)) for goal in task.goals)

    def _name(self, predicate: str) -> str:
        return self.written_as.get(predicate, predicate)

    def _arity(self, predicate: str) -> int:
        return self.domain.vocabulary.arity(predicate) or 0


def _subjects(task: Task) -> list[int]:
    """The objects that a prompt speaks of: those that an answer may name, and the agent."""
    agent = () if task.scene.agent is None else (task.scene.agent,)
    return list(dict.fromkeys((*task.relevant, *agent)))


def _operator_text(operator: Operator) -> str:
    names = {parameter.name: parameter.name for parameter in operator.parameters}
    checks: Sequence[Check] = (*operator.checks, *(check for each in operator.tries for check in each.checks))
    lines = [f"{operator.name}({', '.join(names)})"]
    if operator.description:
        lines[0] += f": {operator.description}"
    for kind, meaning in _MEANING:
        reasons = dict.fromkeys(c.reason.format_map(names) for c in checks if c.fault is kind)
        if reasons:
            lines.append(f"  {meaning}: {'; '.join(reasons)}")
    return "\n".join(lines)


def _is_property(predicate: Predicate) -> bool:
    return predicate.visible and predicate.static and predicate.arity == 1


def _truth(vocabulary: Vocabulary, predicate: str, arity: int) -> tuple[Truth, Frame]:
    """A predicate, stored or derived, as a function of a state and a binding of its arguments."""
    variables = tuple(Variable(name) for name in "xyz"[:arity])
    frame = Frame(variables)
    declared = vocabulary.stored(predicate) or vocabulary.derived_by_name[predicate]
    return Conditions(vocabulary, frame).truth(declared(*variables)), frame


def _lines(texts: Iterable[str]) -> str:
    return "\n".join(texts) or "-"
