"""How much a task asks of whoever solves it, measured on its goals, its scene and its certificate.

How difficult it is expected to be follows from its known plan and its goals, by a ridge regression of the
difficulties that the public tasks of a household had in action sequencing for nine of the paper's models
(`eai.extensions.adaptive.difficulties`, logits from their mean ability), which ``tools/task_difficulty.py``
fits. It says little of a single task: each estimate has its error, the root of the mean squared difference on
titles that were left out.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import NamedTuple

import eai.logic.formula as f
from eai.benchmarks.features import operators_with_tools
from eai.logic.traversal import bound_variables, children, object_names, walk
from eai.tasks.task import Task
from eai.world.derived import Defined
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.frame import AGENT
from eai.world.relation import bits
from eai.world.state import Scene, State
from eai.world.vocabulary import Vocabulary

FILE = "difficulty.json"

FEATURES = ("log steps", "operators", "log goals")
"""The features of any task with a plan: its steps, how many operators they are of, and its goals."""


def features_of(task: Task) -> Sequence[float]:
    """The features of a task with a plan, in order."""
    steps = [action.operator for action in task.script]
    return math.log(len(steps)), float(len(set(steps))), math.log(1 + len(task.goals))


@dataclass(frozen=True, slots=True)
class _DifficultyModel:
    """The coefficients of difficulty in one household.

    Attributes:
        intercept: the difficulty of a task whose features are all zero.
        weights: what one unit of each feature adds.
        error: of an estimate for a task of a title that had no part in the fit.
        r_squared: of the variance of public difficulties the part that such estimates explain.
        rank_correlation: of such estimates with difficulties, by Spearman.
    """

    intercept: float
    weights: Sequence[float]
    error: float
    r_squared: float
    rank_correlation: float

    def expected(self, task: Task) -> float | None:
        """The expected difficulty of a task in logits; None if it has no plan."""
        if not task.script:
            return None
        terms = zip(self.weights, features_of(task), strict=True)
        value = self.intercept + sum([weight * feature for weight, feature in terms])
        return round(value, 2)


def difficulty_model(domain: str) -> _DifficultyModel | None:
    """The model of a household; None of any other benchmark, whose tasks nobody has been asked."""
    return _models().get(domain)


@cache
def _models() -> Mapping[str, _DifficultyModel]:
    text = (resources.files("eai.benchmarks.generator") / FILE).read_text(encoding="utf-8")
    return {name: _DifficultyModel(**found) for name, found in json.loads(text).items()}


class Measure(str, Enum):
    """A quantity that is counted."""

    STEPS = "steps"
    """Those of the certificate."""
    GOALS = "goals"
    OPERATORS = "operators"
    """How many different ones the certificate has."""
    DISTRACTORS = "distractors"
    """The things that neither goals nor certificate concern."""
    CONTAINERS = "containers"
    """The things that the certificate opens, of those that hide what is in them while they are shut."""
    HIDDEN = "hidden"
    """The things of goals and certificate that are not seen before the certificate opens something."""
    TOOL_STEPS = "tool_steps"
    """The steps that need a thing of some kind that they do not name (`eai.benchmarks.features`)."""


class _Lid(NamedTuple):
    """A state of one thing that decides whether others are seen, and whether it lets them be seen or not."""

    predicate: str
    reveals: bool


def measured(task: Task, domain: Domain) -> Mapping[Measure, int]:
    """All that is counted of a task."""
    needed, tools = needed_by(task), operators_with_tools(domain)
    operators = [action.operator for action in task.script]
    containers, hidden = _opened(task, needed, domain)
    return {
        Measure.STEPS: len(operators),
        Measure.GOALS: len(task.goals),
        Measure.OPERATORS: len(set(operators)),
        Measure.DISTRACTORS: len(task.scene.objects) - len(needed),
        Measure.CONTAINERS: len(containers),
        Measure.HIDDEN: len(hidden),
        Measure.TOOL_STEPS: sum(operator in tools for operator in operators),
    }


def _opened(task: Task, needed: set[int], domain: Domain) -> tuple[set[int], set[int]]:
    """The objects that the certificate opens, and those that come to light by it."""
    containers: set[int] = set()
    hidden: set[int] = set()
    known = set(lids(domain))
    states = execute(domain, task.initial, task.script).states if known else ()
    for before, after in pairwise(states):
        opened = {i for lid in known for i in _opened_between(lid, before, after)}
        if opened:
            containers |= opened
            hidden |= {
                i
                for i in needed
                if domain.find_visible(after, 1 << i) and not domain.find_visible(before, 1 << i)
            }
    return containers, hidden


def _opened_between(lid: _Lid, before: State, after: State) -> Iterator[int]:
    then, now = before.mask(lid.predicate), after.mask(lid.predicate)
    return bits(now & ~then if lid.reveals else then & ~now)


def lids(domain: Domain) -> Iterator[_Lid]:
    """The states of other things on which it depends, as the domain declares it, whether a thing is seen."""
    if domain.visible is not None:
        yield from _lids(domain.vocabulary, domain.visible, frozenset({"x"}), (), reveals=True)


def presence(domain: Domain) -> f.Formula:
    """Whether ``x`` is there at all: what is visible for it by no state of other things, nor by the agent.

    What is not, such as the halves of a whole apple, is nowhere to be found, and can only be made.
    """
    visible = domain.visible or f.TRUE
    parts = f.operands(visible, f.And)
    return f.And(tuple([part for part in parts if _is_of_itself(domain.vocabulary, part)]))


def _is_of_itself(vocabulary: Vocabulary, part: f.Formula) -> bool:
    """Whether a condition on ``x`` depends on no lid, and not on the agent."""
    own = frozenset({"x"})
    has_lid = any(True for _ in _lids(vocabulary, part, own, (), reveals=True))
    return not has_lid and all(AGENT not in atom.arguments for atom in _atoms(vocabulary, part))


def _atoms(vocabulary: Vocabulary, formula: f.Formula) -> Iterator[f.Atom]:
    """The atoms of a formula, and of the definitions that it uses."""
    pending, defined = [formula], set[str]()
    while pending:
        for part in walk(pending.pop()):
            if isinstance(part, f.Atom):
                yield part
                derived = vocabulary.derived_by_name.get(part.predicate)
                if isinstance(derived, Defined) and part.predicate not in defined:
                    defined.add(part.predicate)
                    pending.append(derived.definition)


def _lids(
    vocabulary: Vocabulary, formula: f.Formula, own: frozenset[str], within: tuple[str, ...], *, reveals: bool
) -> Iterator[_Lid]:
    """Those of a part of the formula, in which some variables stand for the thing itself."""
    match formula:
        case f.Not(operand):
            yield from _lids(vocabulary, operand, own, within, reveals=not reveals)
        case f.Atom(name, terms):
            stored, derived = vocabulary.find_stored(name), vocabulary.derived_by_name.get(name)
            variables = [term.name if isinstance(term, f.Variable) else None for term in terms]
            if stored is not None and not stored.static and len(variables) == 1:
                if variables[0] is not None and variables[0] not in own:
                    yield _Lid(name, reveals)
            elif isinstance(derived, Defined) and name not in within:
                pairs = zip(derived.parameters, variables, strict=True)
                inner = frozenset([parameter.name for parameter, name in pairs if name in own])
                yield from _lids(vocabulary, derived.definition, inner, (*within, name), reveals=reveals)
        case _:
            for part in children(formula):
                yield from _lids(vocabulary, part, own, within, reveals=reveals)


def needed_by(task: Task) -> set[int]:
    """The objects that the goals name or range over, that the certificate uses, and the agent."""
    used = {index for action in task.script for index in action.arguments}
    asked = {index for each in task.goals for index in spoken_of(each.formula, task.scene)}
    return used | asked | {i for i in (task.scene.agent,) if i is not None}


def spoken_of(goal: f.Formula, scene: Scene) -> Iterator[int]:
    """The objects that a goal names or ranges over."""
    yield from (scene.index[name] for name in object_names(goal))
    for part in walk(goal):
        for variable in bound_variables(part):
            yield from bits(scene.category(variable.category))
