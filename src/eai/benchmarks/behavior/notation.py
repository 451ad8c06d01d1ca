"""The notations of answers to BEHAVIOR's prompts: goals and subgoals, and the names that they may use.

Goals name objects by instance, as in ``rag.n.01_1``. Subgoals are an object with the key ``output``, anywhere
in the text: a list of formulas. ``toggled.on`` and the hyphen of t-shirts are spelt as formulas can have
them, which is the repair ``spelling``. The prompt rules out quantifiers and the robot as an object: a
quantifier cannot be read, and literals about the robot are taken to hold.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import ClassVar

from eai.abilities.notation.goals import Alternatives, JsonGoals, SpelledPredicate
from eai.abilities.notation.plans import JsonPlans
from eai.abilities.notation.subgoals import SubgoalNotation, WrittenSubgoals, read_output
from eai.abilities.verdict import Unreadable
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.records import GoalCondition, GroundOption
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.logic.choice import AllOf, AnyOf, Choice, Literal, LiteralChoice
from eai.logic.formula import Atom, Constant, Not
from eai.logic.signature import Signature
from eai.tasks.lexicon import FormulaLexicon
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.state import Scene

STATES = tuple(state.name for state in p.GOAL_STATES if state.name != "burnt")
"""The states that goals of the published file speak of."""

RELATIONS = tuple(sorted([*(relation.name for relation in p.GOAL_RELATIONS), "touching"]))
"""The relations of the same."""

_UNARY_PREDICATES = (
    *(state.name.replace("toggled_on", "toggledon") for state in p.GOAL_STATES),
    "holds_rh",
    "holds_lh",
)
_ROBOT_PREDICATES = ("inFOVOfRobot", "inHandOfRobot", "inReachOfRobot", "inSameRoomAsRobot")
_ROOMS = (
    "Undefined",
    "BedRoom",
    "EmptyRoom",
    "DiningRoom",
    "PantryRoom",
    "Garage",
    "Bathroom",
    "PlayRoom",
    "HomeOffice",
    "Library",
    "Staircase",
    "Kitchen",
    "LivingRoom",
    "ExerciseRoom",
    "Corridor",
    "Auditorium",
    "TelevisionRoom",
    "Lobby",
    "Balcony",
    "StorageRoom",
    "ChildsRoom",
    "Closet",
    "UtilityRoom",
)

PREDICATE_ARITIES: Mapping[str, int] = {
    **dict.fromkeys((*_UNARY_PREDICATES, *_ROBOT_PREDICATES), 1),
    **{f"isIn{room}": 1 for room in _ROOMS},
    **dict.fromkeys(RELATIONS, 2),
}
"""Every predicate of subgoals with its number of objects (``base_vocabulary.json``)."""

UNOBSERVED = frozenset(PREDICATE_ARITIES) - {*_UNARY_PREDICATES, *RELATIONS, "inHandOfRobot"}
"""Predicates about rooms, sight and reach, of which the symbolic scene knows nothing."""

ROBOT_NAMES = frozenset(("agent", "agent_n_01", "agent.1", "agent_n_01.1"))
"""Names of the robot in subgoals. The symbolic scene does not know where it is."""

DOMAIN_NAMES: Mapping[str, str] = {
    "toggledon": "toggled_on",
    "touching": "nextto",
    "inHandOfRobot": p.held.name,
    "holds_rh": p.in_right_hand.name,
    "holds_lh": p.in_left_hand.name,
}
"""Predicate of answers -> its name in the domain, where that is another."""

ACTION_ARITIES: Mapping[str, int | None] = {
    **{operator.name.lower(): operator.arity for operator in behavior.as_meant().operators},
    **dict.fromkeys(("burn", "stain", "unclean")),
}
"""Every action with its number of objects; of three the vocabulary does not say it."""

_NUMBERED = re.compile(r"(.+)_(\d+)")


def make_lexicon(scene: Scene, signature: Signature, objects: Mapping[str, int]) -> FormulaLexicon:
    """The meanings of these names in the domain."""
    categories = {
        n: c for n, c in map_category_predicates(scene).items() if scene.vocabulary.arity(n) is None
    }
    actions = {name: name.upper() for name in ACTION_ARITIES}
    return FormulaLexicon(
        scene, signature, objects, DOMAIN_NAMES, actions, categories, UNOBSERVED, ROBOT_NAMES
    )


def map_category_predicates(scene: Scene) -> dict[str, str]:
    """The predicates that say that an object is of a category -> the category."""
    categories = dict.fromkeys(thing.category for thing in scene.objects)
    return {category.replace(".", "_"): category for category in categories if "." in category}


def map_object_names(scene: Scene) -> dict[str, int]:
    """Name that an object may have -> the object: ``jar.0``, also ``jar_0``.

    Names of formulas have no hyphens; where an object's name does, an underscore stands for it.
    """
    names = {thing.name.replace("-", "_"): i for i, thing in enumerate(scene.objects)}
    return {**names, **{_write_dotted(name): i for name, i in names.items()}}


def map_published_names(scene: Scene) -> dict[str, int]:
    """Name in the reference -> the object of a task; parts of objects have none."""
    return {_write_dotted(thing.name): i for i, thing in enumerate(scene.objects) if "." in thing.category}


def _write_dotted(name: str) -> str:
    match = _NUMBERED.fullmatch(name)
    return name if match is None else f"{match[1]}.{match[2]}"


_SPELLINGS = (("toggled.on", "toggledon"), ("toggled_on", "toggledon"), ("t-shirt", "t_shirt"))


class BehaviorSubgoals(SubgoalNotation):
    """The words of BEHAVIOR's prompts."""

    def __init__(self) -> None:
        super().__init__(behavior.as_meant())

    def lexicon(self, scene: Scene) -> FormulaLexicon:
        """The prompts' names of states, actions and objects."""
        known = {name: arity for name, arity in ACTION_ARITIES.items() if arity is not None}
        objects = map_object_names(scene)
        names = {*objects, *ROBOT_NAMES}
        predicates = {**dict.fromkeys(map_category_predicates(scene), 1), **PREDICATE_ARITIES}
        return make_lexicon(scene, Signature(predicates, known, names), objects)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """Read the subgoals in an answer, or say why they cannot be read."""
        written = read_output(text, frozenset())
        if isinstance(written, Unreadable):
            return written
        subgoals = tuple(map(_respell, written.subgoals))
        repairs = written.repairs if subgoals == written.subgoals else (*written.repairs, "spelling")
        return replace(written, subgoals=subgoals, repairs=repairs)


def _respell(subgoal: str) -> str:
    for written, meant in _SPELLINGS:
        subgoal = subgoal.replace(written, meant)
    return subgoal


class _BehaviorPlans(JsonPlans):
    """The default notation of plans, which also knows the names of goals, as in ``rag.n.01_1``."""

    def objects(self, task: Task) -> Callable[[object], int | None]:
        """Return the lookup of names of the scene and of goals."""
        find = super().objects(task)
        index = {instance: task.scene.index[name] for name, instance in _map_instances(task).items()}

        def object_of(word: object) -> int | None:
            number = find(word)
            return index.get(word) if number is None and isinstance(word, str) else number

        return object_of


PLANS = _BehaviorPlans()
"""The notation of plans."""


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

    def words(self, domain: Domain) -> Mapping[SpelledPredicate, str]:
        """The states and relations that goals of the published file speak of; touching is being next to."""
        arities = {**dict.fromkeys(STATES, 1), **dict.fromkeys(RELATIONS, 2)}
        return {(name, arity): DOMAIN_NAMES.get(name, name) for name, arity in arities.items()}

    def names(self, task: Task) -> tuple[str, ...]:
        """The instance that each object is; parts of objects are none."""
        instances = _map_instances(task)
        return tuple([instances.get(thing.name, thing.name) for thing in task.scene.objects])

    def alternatives(self, task: Task) -> tuple[Alternatives, ...]:
        """The published goals, each as its ground options; of a task that is not published, its own."""
        if not isinstance(task, BehaviorTask):
            return super().alternatives(task)
        names = {instance: name for name, instance in _map_instances(task).items()}

        @cache  # most conditions stand in many options of a goal
        def leaf(condition: GoalCondition) -> LiteralChoice:
            return LiteralChoice(_to_literal(condition, names))

        def choice(options: tuple[GroundOption, ...]) -> Choice:
            return AnyOf(tuple([AllOf(tuple(map(leaf, option))) for option in options]))

        return tuple([Alternatives("condition", None, choice(each)) for each in task.record.goal_options])


def _map_instances(task: Task) -> Mapping[str, str]:
    """The instance that each object is, by the object's name; nothing where the task is not published."""
    things = task.record.objects if isinstance(task, BehaviorTask) else ()
    return {thing.name: thing.instance for thing in things}


def _to_literal(condition: GoalCondition, names: Mapping[str, str]) -> Literal:
    predicate, *arguments = condition
    if predicate == "not":
        return Not(_to_literal(tuple(arguments[0]), names))
    return Atom(str(predicate), tuple(Constant(names[str(argument)]) for argument in arguments))
