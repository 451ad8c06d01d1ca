"""The vocabulary of answers to a task, and in it the goals of the task, with all ways to meet each."""

from __future__ import annotations

from collections import Counter
from math import prod

from eai.abilities.goal_interpretation.notation import GoalNotation, WrittenGoal
from eai.abilities.task import GoalKind, Task
from eai.logic.choice import Literal, choice_options
from eai.logic.formula import Atom, Constant, Not, Occurs, Term
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
        """The goal as all ways to state it come out."""
        if goal.predicate in self._symmetric:
            return goal._replace(names=tuple(sorted(goal.names)))
        return goal

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
