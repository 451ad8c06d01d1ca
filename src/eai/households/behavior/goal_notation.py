"""How answers to BEHAVIOR's goal interpretation state goals: objects by instance, as in ``rag.n.01_1``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from eai.abilities.goal_interpretation.notation import Alternatives, JsonGoals, Word
from eai.abilities.task import GoalKind, Task
from eai.households.behavior.records import Condition
from eai.households.behavior.subgoal_notation import IN_DOMAIN
from eai.households.behavior.tasks import BehaviorTask
from eai.logic.choice import AllOf, AnyOf, Leaf, Literal
from eai.logic.formula import Atom, Constant, Not
from eai.world.domain import Domain

STATES = ("cooked", "dusty", "frozen", "open", "sliced", "soaked", "stained", "toggled_on")
RELATIONS = ("inside", "nextto", "onfloor", "ontop", "touching", "under")


class BehaviorGoals(JsonGoals):
    """Capitals do not matter, ``toggledon`` is another spelling of ``toggled_on``; there are no actions.

    The goals are those of a published file, in which a few are not those of the problem files.
    """

    symmetric: ClassVar[frozenset[str]] = frozenset({"nextto", "touching"})

    def __init__(self) -> None:
        super().__init__((GoalKind.STATE, GoalKind.RELATION))

    def word(self, text: str) -> str:
        """A word in small letters."""
        return text.strip().lower().replace("toggledon", "toggled_on")

    def words(self, domain: Domain) -> Mapping[Word, str]:
        """The states and relations that goals of the published file speak of; touching is being next to."""
        arities = {**dict.fromkeys(STATES, 1), **dict.fromkeys(RELATIONS, 2)}
        return {Word(name, arity): IN_DOMAIN.get(name, name) for name, arity in arities.items()}

    def names(self, task: Task) -> tuple[str, ...]:
        """The instance that each object is; parts of objects are none."""
        instances = _instances(task)
        return tuple([instances.get(thing.name, thing.name) for thing in task.scene.objects])

    def alternatives(self, task: Task) -> tuple[Alternatives, ...]:
        """The published goals, each as its ground options; of a task that is not published, its own."""
        if not isinstance(task, BehaviorTask):
            return super().alternatives(task)
        names = {instance: name for name, instance in _instances(task).items()}
        known: dict[Condition, Leaf] = {}

        def leaf(condition: Condition) -> Leaf:
            """The condition; most stand in many options of a goal."""
            found = known.get(condition)
            if found is None:
                found = known[condition] = Leaf(_literal(condition, names))
            return found

        return tuple(
            [
                Alternatives(
                    "condition",
                    None,
                    AnyOf(tuple([AllOf(tuple([leaf(each) for each in option])) for option in options])),
                )
                for options in task.interpretation_goals
            ]
        )


def _instances(task: Task) -> Mapping[str, str]:
    """The instance that each object is, by the object's name; nothing where the task is not published."""
    things = task.record.objects if isinstance(task, BehaviorTask) else ()
    return {thing.name: thing.instance for thing in things}


def _literal(condition: Condition, names: Mapping[str, str]) -> Literal:
    predicate, *arguments = condition
    if predicate == "not":
        return Not(_literal(tuple(arguments[0]), names))
    return Atom(str(predicate), tuple(Constant(names[str(argument)]) for argument in arguments))
