"""Translate goals between a task and the answers of goal interpretation.

A `GoalLexicon` has the names that answers to a task may use. `write_goals` writes the task's goals with these
names.

`read_stated_goals` translates an answer into goals (`eai.tasks.task.Goal`). A question of another ability can
then state these goals instead of the task's own. Well-formed goals are kept even if they are wrong. Their
unknown names stay as written. Ill-formed goals are left out, and an unreadable answer states no goals. The
scorer of goal interpretation reads only literals and actions. `read_stated_goals` also reads connectives and
quantifiers, if the benchmark's answers can have them.
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
from eai.logic.choice import Literal, generate_dnf_terms_of_tree
from eai.logic.formula import Atom, Constant, Formula, Not, Occurs, Term
from eai.logic.signature import make_term
from eai.logic.traversal import find_object_names, walk_subformulas
from eai.tasks.task import Goal, GoalKind, Task, goal
from eai.world.domain import Domain


class GoalLexicon:
    """The vocabulary of answers to a task.

    Attributes:
        words: the names of predicates in answers, with their numbers of objects.
        actions: names of the actions.
        objects: mapping from names of objects to the number of objects with this name.
    """

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        words = notation.map_spellings_to_predicate_names(domain)
        self.words = words.keys()
        self.actions = domain.operator_arities.keys()
        names = notation.list_object_names(task)
        self.objects = Counter([names[index] for index in task.relevant])
        self._name_of = {
            scene_object.name: name for scene_object, name in zip(task.scene.objects, names, strict=True)
        }
        self._symmetric = notation.symmetric
        self._spelling = {predicate: word for (word, _), predicate in reversed(tuple(words.items()))}
        self._arity = dict(self.words)

    def classify_goal(self, goal: WrittenGoal) -> GoalKind:
        """Return the kind of a goal, by the arity of its predicate.

        If the predicate is unknown, return the kind by the number of the goal's objects.
        """
        if goal.is_action:
            return GoalKind.ACTION
        arity = len(goal.names)
        if (goal.predicate, arity) not in self.words:
            arity = self._arity.get(goal.predicate, arity)
        return GoalKind.STATE if arity < 2 else GoalKind.RELATION

    def is_well_formed(self, goal: WrittenGoal) -> bool:
        """Whether a goal has as many objects as its predicate takes; one or two for an unknown predicate."""
        if goal.is_action or (goal.predicate, len(goal.names)) in self.words:
            return True
        return goal.predicate not in self._arity and 0 < len(goal.names) < 3

    def has_predicate_of_goal(self, goal: WrittenGoal) -> bool:
        """Whether the predicate of a goal is in this lexicon. The number of objects is not compared.

        True for goals that are actions.
        """
        return goal.is_action or goal.predicate in self._arity

    def find_unknown_name(self, goal: WrittenGoal) -> str | None:
        """Return the first unknown name in a goal, or None. Objects are checked before the predicate."""
        for name in goal.names:
            if name not in self.objects:
                return name
        if goal.is_action:
            return None if goal.predicate in self.actions else goal.predicate
        return None if goal.predicate in self._arity else goal.predicate

    def count_possible_object_tuples(self, goal: WrittenGoal) -> int:
        """Return how many different tuples of objects the names in a goal can mean."""
        return prod([self.objects[name] for name in goal.names])

    def canonicalize(self, goal: WrittenGoal) -> WrittenGoal:
        """Return the canonical form of a goal, which is the same for all goals with the same meaning."""
        if goal.predicate in self._symmetric:
            return goal._replace(names=tuple(sorted(goal.names)))
        return goal

    def replace_scene_names_by_answer_names(self, goal: WrittenGoal) -> WrittenGoal:
        """Return a goal with the objects' names for answers in place of their names in the scene.

        An answer may also use the names in the scene, because messages to the model show these names.
        """
        if all(name in self.objects for name in goal.names):
            return goal
        return goal._replace(names=tuple(map(self._get_name_in_answers, goal.names)))

    def _get_name_in_answers(self, scene_name: str) -> str:
        """Return an object's name in answers, given its name in the scene."""
        in_scene = scene_name if scene_name in self._name_of else "_".join(scene_name.rsplit(".", 1))
        return scene_name if scene_name in self.objects else self._name_of.get(in_scene, scene_name)

    def to_goal_with_answer_names(self, literal: Literal) -> WrittenGoal:
        """Return a condition as a goal in an answer, with the names that answers use for objects."""
        ground = self.to_goal_with_scene_names(literal)
        return ground._replace(names=tuple([self._name_of[name] for name in ground.names]))

    def to_goal_with_scene_names(self, literal: Literal) -> WrittenGoal:
        """Return a condition as a goal.

        The predicate has its name for answers, the objects their scene names.
        """
        positive = not isinstance(literal, Not)
        match literal.operand if isinstance(literal, Not) else literal:
            case Occurs(action, arguments):
                return WrittenGoal(action, _get_object_names(arguments), positive, is_action=True)
            case Atom(predicate, arguments):
                word = self._spelling.get(predicate, predicate)
                return WrittenGoal(word, _get_object_names(arguments), positive)
            case other:
                raise TypeError(
                    f"cannot write {other} as a goal: expected an atom, a negated atom or an action"
                )


def _get_object_names(arguments: tuple[Term, ...]) -> tuple[str, ...]:
    return tuple([term.name for term in arguments if isinstance(term, Constant)])


def write_goals(task: Task, domain: Domain, notation: GoalNotation) -> tuple[str, ...]:
    """Return the goals of a right answer as texts.

    If several sets of conditions (options) reach a goal, the texts state the first option.
    """
    task = task.without_goals_over_time
    lexicon = GoalLexicon(task, domain, notation)
    options = [
        next(generate_dnf_terms_of_tree(goal.options), ())
        for goal in notation.list_alternatives_of_goals(task)
    ]
    conditions = dict.fromkeys(condition for option in options for condition in option)
    return notation.write([lexicon.to_goal_with_answer_names(condition) for condition in conditions])


@dataclass(frozen=True, slots=True)
class _GoalsStatedByAnswer:
    """The goals that an answer states, as goals of its task.

    Attributes:
        goals: the stated goals, each once, in order.
        meaningful: the stated goals without an unknown name, in order.
        unknown: the unknown names of predicates, actions and objects, each once.
        left_out: the ill-formed entries of the answer, as texts.
        unreadable: the reason why the answer cannot be read; None if it was read.
    """

    goals: tuple[Goal, ...]
    meaningful: tuple[Goal, ...] = ()
    unknown: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    unreadable: str | None = None


def read_stated_goals(text: str, task: Task, domain: Domain, notation: GoalNotation) -> _GoalsStatedByAnswer:
    """Return the goals that an answer to goal interpretation states for a task."""
    translator = _GoalToFormulaTranslator(task, domain, notation)
    read = notation.read_conditions(text, translator.to_formula)
    if isinstance(read, Unreadable):
        return _GoalsStatedByAnswer((), unreadable=read.reason)
    formulas, left_out = read
    strange = {formula: tuple(translator.find_unknown_names(formula)) for formula in formulas}
    return _GoalsStatedByAnswer(
        tuple([goal(formula) for formula in strange]),
        tuple([goal(formula) for formula, names in strange.items() if not names]),
        tuple(dict.fromkeys(name for names in strange.values() for name in names)),
        left_out,
    )


class _GoalToFormulaTranslator:
    """Translates the words of an answer into formulas about the scene of a task.

    If several objects of the task have the same name, the name in an answer means the object that the task
    lists last. Plans without object numbers are read in the same way. If an answer repeats a goal about one
    or two objects, each repetition means other objects with the same names, from the last to the first. The
    reason is that the scorer of goal interpretation counts repeated goals.
    """

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        self._lexicon = GoalLexicon(task, domain, notation)
        self._predicates = notation.map_spellings_to_predicate_names(domain)
        self._vocabulary, self._actions = domain.vocabulary, domain.operator_arities
        names, things = notation.list_object_names(task), task.scene.objects
        self._named = group_pairs((names[index], things[index].name) for index in reversed(task.relevant))
        self._known = {scene_object for things in self._named.values() for scene_object in things}
        self._times: Counter[WrittenGoal] = Counter()

    def to_formula(self, stated_goal: WrittenGoal, variables: frozenset[str]) -> Formula | None:
        """Return a stated goal as a formula, or None if the goal is ill-formed.

        ``variables`` contains the names of the variables that quantifiers around the goal bind.
        """
        if not self._lexicon.is_well_formed(stated_goal):
            return None
        terms = tuple(
            [make_term(name, variables) for name in self._find_meant_objects(stated_goal, variables)]
        )
        if stated_goal.is_action:
            return Occurs(stated_goal.predicate, terms)
        atom = Atom(self._predicates.get((stated_goal.predicate, len(terms)), stated_goal.predicate), terms)
        return atom if stated_goal.positive else ~atom

    def find_unknown_names(self, formula: Formula) -> Iterator[str]:
        """Yield the unknown names in a formula."""
        for part in walk_subformulas(formula):
            match part:
                case Atom(name, terms) if self._vocabulary.find_arity(name) != len(terms):
                    yield name
                case Occurs(name) if name not in self._actions:
                    yield name
        yield from (name for name in find_object_names(formula) if name not in self._known)

    def _find_meant_objects(self, stated_goal: WrittenGoal, variables: frozenset[str]) -> tuple[str, ...]:
        """Return the scene's names of the objects that a goal means. Unknown names are kept."""
        named = [[name] if name in variables else self._named.get(name, [name]) for name in stated_goal.names]
        first = tuple([things[0] for things in named])
        if len(first) > 2:  # repetitions of a goal with three or more names mean the same objects
            return first
        meant = [chosen for chosen in product(*named) if len({*chosen}) == len(chosen)] or [first]
        self._times[stated_goal] += 1
        return meant[min(self._times[stated_goal], len(meant)) - 1]
