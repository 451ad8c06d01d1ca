"""The vocabulary of answers to a task, the goals of the task in it, and what goals of an answer mean there.

Someone may take the goals of an answer to goal interpretation for the task's (`read_stated`). They are read
as goal interpretation reads them, with one difference: where the notation has connectives and quantifiers,
they are understood too, though no answer is compared with them. What is well-formed is asked for as it
stands, be it right or wrong, and a name that means nothing stays in it as it was written. What is ill-formed
is left out. An answer that cannot be read states no goals.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import prod

from eai.abilities.notation.goals import GoalNotation, WrittenGoal
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.logic.choice import Literal, choice_options
from eai.logic.formula import Atom, Constant, Formula, Not, Occurs, Term
from eai.logic.signature import to_term
from eai.logic.traversal import object_names, walk
from eai.tasks.task import Goal, GoalKind, Task, goal
from eai.world.domain import Domain


class GoalLexicon:
    """The vocabulary of answers to a task, and how it is written.

    Attributes:
        words: the predicates, as spelt.
        actions: the actions.
        objects: the names of objects, and of how many each is the name.
    """

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        words = notation.words(domain)
        self.words = words.keys()
        self.actions = domain.arities.keys()
        names = notation.names(task)
        self.objects = Counter([names[index] for index in task.relevant])
        self._name_of = {thing.name: name for thing, name in zip(task.scene.objects, names, strict=True)}
        self._symmetric = notation.symmetric
        self._spelling = {predicate: word for (word, _), predicate in reversed(tuple(words.items()))}
        self._arity = dict(self.words)

    def kind(self, goal: WrittenGoal) -> GoalKind:
        """State or relation: by the predicate where there is one, else by the number of objects."""
        if goal.is_action:
            return GoalKind.ACTION
        arity = len(goal.names)
        if (goal.predicate, arity) not in self.words:
            arity = self._arity.get(goal.predicate, arity)
        return GoalKind.STATE if arity < 2 else GoalKind.RELATION

    def is_well_formed(self, goal: WrittenGoal) -> bool:
        """Whether it has as many objects as its predicate; one or two if there is no such predicate."""
        if goal.is_action or (goal.predicate, len(goal.names)) in self.words:
            return True
        return goal.predicate not in self._arity and 0 < len(goal.names) < 3

    def has_predicate(self, goal: WrittenGoal) -> bool:
        """Whether there is such a predicate, of however many objects."""
        return goal.is_action or goal.predicate in self._arity

    def first_unknown(self, goal: WrittenGoal) -> str | None:
        """The first name in a goal that means nothing: an object, else the predicate or action."""
        for name in goal.names:
            if name not in self.objects:
                return name
        if goal.is_action:
            return None if goal.predicate in self.actions else goal.predicate
        return None if goal.predicate in self._arity else goal.predicate

    def instances(self, goal: WrittenGoal) -> int:
        """Of how many different objects, or pairs of them, the goal can be said."""
        return prod([self.objects[name] for name in goal.names])

    def canonical(self, goal: WrittenGoal) -> WrittenGoal:
        """Return the goal in the one way to state it, of all ways that mean the same."""
        if goal.predicate in self._symmetric:
            return goal._replace(names=tuple(sorted(goal.names)))
        return goal

    def with_answer_names(self, goal: WrittenGoal) -> WrittenGoal:
        """Return a goal of an answer in which no object is called as in the scene, as messages do."""
        if all(name in self.objects for name in goal.names):
            return goal
        return goal._replace(names=tuple(map(self._answer_name, goal.names)))

    def _answer_name(self, name: str) -> str:
        """Return the name that answers have for an object that is called as in the scene, as in messages."""
        in_scene = name if name in self._name_of else "_".join(name.rsplit(".", 1))
        return name if name in self.objects else self._name_of.get(in_scene, name)

    def spelt(self, literal: Literal) -> WrittenGoal:
        """A condition in the words of answers."""
        ground = self.grounded(literal)
        return ground._replace(names=tuple([self._name_of[name] for name in ground.names]))

    def grounded(self, literal: Literal) -> WrittenGoal:
        """A condition in the words of answers, said of objects by their full names."""
        positive = not isinstance(literal, Not)
        match literal.operand if isinstance(literal, Not) else literal:
            case Occurs(action, arguments):
                return WrittenGoal(action, _names(arguments), positive, is_action=True)
            case Atom(predicate, arguments):
                word = self._spelling.get(predicate, predicate)
                return WrittenGoal(word, _names(arguments), positive)
            case other:
                raise TypeError(f"{other} is no condition")


def _names(arguments: tuple[Term, ...]) -> tuple[str, ...]:
    return tuple([term.name for term in arguments if isinstance(term, Constant)])


def write_goals(task: Task, domain: Domain, notation: GoalNotation) -> tuple[str, ...]:
    """A right answer, in parts: the first option of each goal at the end."""
    task = task.at_the_end
    lexicon = GoalLexicon(task, domain, notation)
    options = [next(choice_options(goal.options), ()) for goal in notation.alternatives(task)]
    conditions = dict.fromkeys(condition for option in options for condition in option)
    return notation.write([lexicon.spelt(condition) for condition in conditions])


@dataclass(frozen=True, slots=True)
class _StatedGoals:
    """The goals that an answer states, as goals of its task.

    Attributes:
        goals: each once, in order.
        meaningful: those of them all of whose names mean something, in order.
        unknown: the names that mean nothing, each once: predicates, actions, objects.
        left_out: the ill-formed entries of the answer, as texts.
        unreadable: why no goals could be read; None if the answer could be.
    """

    goals: tuple[Goal, ...]
    meaningful: tuple[Goal, ...] = ()
    unknown: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    unreadable: str | None = None


def read_stated(text: str, task: Task, domain: Domain, notation: GoalNotation) -> _StatedGoals:
    """The goals that an answer to goal interpretation states for a task."""
    meaning = _Meaning(task, domain, notation)
    read = notation.conditions(text, meaning.formula)
    if isinstance(read, Unreadable):
        return _StatedGoals((), unreadable=read.reason)
    formulas, left_out = read
    strange = {formula: tuple(meaning.unknown(formula)) for formula in formulas}
    return _StatedGoals(
        tuple([goal(formula) for formula in strange]),
        tuple([goal(formula) for formula, names in strange.items() if not names]),
        tuple(dict.fromkeys(name for names in strange.values() for name in names)),
        left_out,
    )


class _Meaning:
    """The meaning of the words of an answer in a task.

    A name that several objects share means the last of them, as in a plan of names alone. Said once more, a
    goal is meant of the object before, as goal interpretation counts it.
    """

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        self._lexicon = GoalLexicon(task, domain, notation)
        self._predicates = notation.words(domain)
        self._vocabulary, self._actions = domain.vocabulary, domain.arities
        names, things = notation.names(task), task.scene.objects
        self._named = group_pairs((names[index], things[index].name) for index in reversed(task.relevant))
        self._known = {thing for things in self._named.values() for thing in things}
        self._times: Counter[WrittenGoal] = Counter()

    def formula(self, said: WrittenGoal, variables: frozenset[str]) -> Formula | None:
        """The meaning of a goal below quantifiers that bind these variables; None if it is ill-formed."""
        if not self._lexicon.is_well_formed(said):
            return None
        terms = tuple([to_term(name, variables) for name in self._objects(said, variables)])
        if said.is_action:
            return Occurs(said.predicate, terms)
        atom = Atom(self._predicates.get((said.predicate, len(terms)), said.predicate), terms)
        return atom if said.positive else ~atom

    def unknown(self, formula: Formula) -> Iterator[str]:
        """The names in a formula that mean nothing."""
        for part in walk(formula):
            match part:
                case Atom(name, terms) if self._vocabulary.arity(name) != len(terms):
                    yield name
                case Occurs(name) if name not in self._actions:
                    yield name
        yield from (name for name in object_names(formula) if name not in self._known)

    def _objects(self, said: WrittenGoal, variables: frozenset[str]) -> tuple[str, ...]:
        """The objects that a goal is meant of; what is no object's name stays."""
        named = [[name] if name in variables else self._named.get(name, [name]) for name in said.names]
        first = tuple([things[0] for things in named])
        if len(first) > 2:  # of so many no other reading is tried
            return first
        meant = [chosen for chosen in product(*named) if len({*chosen}) == len(chosen)] or [first]
        self._times[said] += 1
        return meant[min(self._times[said], len(meant)) - 1]
