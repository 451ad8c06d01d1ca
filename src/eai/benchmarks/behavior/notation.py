"""The notations of goals and subgoals in answers to BEHAVIOR's prompts, and the names that answers may use.

Goals name objects by instance, as in ``rag.n.01_1``. Subgoals are a list of formulas under the key ``output``
of a JSON object, anywhere in the text. The spellings ``toggled.on`` and ``t-shirt`` are corrected before
formulas are read. Verdicts list this correction as the repair ``spelling``. The prompt forbids quantifiers
and the robot as an object. A formula with a quantifier is therefore unreadable, and a literal about the robot
counts as true.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import ClassVar

from eai.abilities.notation.goals import GoalAlternatives, JsonGoalNotation, SpellingAndArity
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.notation.subgoals import (
    SubgoalNotation,
    WrittenSubgoals,
    read_subgoals_from_json_output_list,
)
from eai.abilities.verdict import Unreadable
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.records import GoalCondition, GroundOption
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.logic.choice import AndNode, AndOrTree, AndOrTreeLiteral, Literal, OrNode
from eai.logic.formula import Atom, Constant, Not
from eai.logic.signature import FormulaSignature
from eai.tasks.lexicon import FormulaNameLexicon
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.state import Scene

STATES = tuple(state.name for state in p.GOAL_STATES if state.name != "burnt")
"""Predicates of one object that occur in the data set's file of goals."""

RELATIONS = tuple(sorted([*(relation.name for relation in p.GOAL_RELATIONS), "touching"]))
"""Predicates of two objects that occur in the data set's file of goals."""

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
"""Number of arguments of each predicate of subgoals (``base_vocabulary.json``)."""

UNOBSERVED = frozenset(PREDICATE_ARITIES) - {*_UNARY_PREDICATES, *RELATIONS, "inHandOfRobot"}
"""Predicates that cannot be evaluated: states have no rooms, and no robot's position, view or reach."""

ROBOT_NAMES = frozenset(("agent", "agent_n_01", "agent.1", "agent_n_01.1"))
"""Names of the robot in subgoals. States do not contain the robot's position."""

DOMAIN_NAMES: Mapping[str, str] = {
    "toggledon": "toggled_on",
    "touching": "nextto",
    "inHandOfRobot": p.held.name,
    "holds_rh": p.in_right_hand.name,
    "holds_lh": p.in_left_hand.name,
}
"""Predicate in answers -> name of the predicate in the domain, if the names differ."""

ACTION_ARITIES: Mapping[str, int | None] = {
    **{
        operator.name.lower(): operator.arity
        for operator in behavior.make_domain_with_checks_in_paper_order().operators
    },
    **dict.fromkeys(("burn", "stain", "unclean")),
}
"""Action -> number of its objects; None for three actions without a number in ``base_vocabulary.json``."""

_NUMBERED = re.compile(r"(.+)_(\d+)")


def make_behavior_lexicon(
    scene: Scene, signature: FormulaSignature, objects: Mapping[str, int]
) -> FormulaNameLexicon:
    """Return the lexicon of a scene, which maps names in answers to names in the domain.

    Args:
        scene: the scene.
        signature: the names that formulas may use.
        objects: name -> index of the object that the name means.
    """
    categories = {
        n: c for n, c in map_predicates_to_categories(scene).items() if scene.vocabulary.find_arity(n) is None
    }
    actions = {name: name.upper() for name in ACTION_ARITIES}
    return FormulaNameLexicon(
        scene, signature, objects, DOMAIN_NAMES, actions, categories, UNOBSERVED, ROBOT_NAMES
    )


def map_predicates_to_categories(scene: Scene) -> dict[str, str]:
    """Return a mapping from predicates that state an object's category to this category.

    For example, ``jar_n_01`` is mapped to ``jar.n.01``.
    """
    categories = dict.fromkeys(obj.category for obj in scene.objects)
    return {category.replace(".", "_"): category for category in categories if "." in category}


def map_object_names(scene: Scene) -> dict[str, int]:
    """Return a mapping from each accepted name to the index of its object: both ``jar.0`` and ``jar_0``.

    Hyphens become underscores: ``half-jar_0`` is accepted as ``half_jar_0`` and ``half_jar.0``.
    """
    names = {obj.name.replace("-", "_"): i for i, obj in enumerate(scene.objects)}
    return {**names, **{_replace_underscore_before_number_with_dot(name): i for name, i in names.items()}}


def map_object_names_of_paper_to_indices(scene: Scene) -> dict[str, int]:
    """Return a mapping from object names in the paper's package to indices.

    Parts of objects have no such name.
    """
    return {
        _replace_underscore_before_number_with_dot(obj.name): i
        for i, obj in enumerate(scene.objects)
        if "." in obj.category
    }


def _replace_underscore_before_number_with_dot(name: str) -> str:
    match = _NUMBERED.fullmatch(name)
    return name if match is None else f"{match[1]}.{match[2]}"


_SPELLINGS = (("toggled.on", "toggledon"), ("toggled_on", "toggledon"), ("t-shirt", "t_shirt"))
_ARITIES = {**PREDICATE_ARITIES, **ACTION_ARITIES, **dict.fromkeys(word for word, _ in _SPELLINGS)}


class BehaviorSubgoalNotation(SubgoalNotation):
    """The notation of subgoals in answers to BEHAVIOR's prompts."""

    def __init__(self) -> None:
        super().__init__(behavior.make_domain_with_checks_in_paper_order())

    def make_lexicon_of_names_in_subgoals(self, scene: Scene) -> FormulaNameLexicon:
        """Return the lexicon of a scene: the names that prompts use for its states, actions and objects."""
        actions = {name: arity for name, arity in ACTION_ARITIES.items() if arity is not None}
        objects = map_object_names(scene)
        names = {*objects, *ROBOT_NAMES}
        predicates = {**dict.fromkeys(map_predicates_to_categories(scene), 1), **PREDICATE_ARITIES}
        return make_behavior_lexicon(scene, FormulaSignature(predicates, actions, names), objects)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """Return the subgoals in an answer, or the reason why the answer cannot be read."""
        written = read_subgoals_from_json_output_list(text, _ARITIES)
        if isinstance(written, Unreadable):
            return written
        subgoals = tuple(map(_normalize_subgoal, written.subgoals))
        repairs = written.repairs if subgoals == written.subgoals else (*written.repairs, "spelling")
        return replace(written, subgoals=subgoals, repairs=repairs)


def _normalize_subgoal(subgoal: str) -> str:
    for written, accepted in _SPELLINGS:
        subgoal = subgoal.replace(written, accepted)
    return subgoal


class _PlanNotationWithInstanceNames(JsonPlanNotation):
    """eai's usual notation of plans, in which objects may also have instance names: ``rag.n.01_1``."""

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return the function that finds an object by its name or its instance name."""
        find = super().make_object_lookup(task)
        index = {
            instance: task.scene.index[name] for name, instance in _map_object_to_instance_names(task).items()
        }

        def find_object(word: object) -> int | None:
            number = find(word)
            return index.get(word) if number is None and isinstance(word, str) else number

        return find_object


PLANS = _PlanNotationWithInstanceNames()
"""The notation of plans in answers to BEHAVIOR's prompts."""


class BehaviorGoalNotation(JsonGoalNotation):
    """The notation of goals in BEHAVIOR's prompts: states and relations, no actions.

    Capital letters make no difference. ``toggledon`` is another spelling of ``toggled_on``. The right goals
    come from the data set's file of goals. A few of them differ from the goals in the problem files.
    """

    symmetric: ClassVar[frozenset[str]] = frozenset({"nextto", "touching"})

    def __init__(self) -> None:
        super().__init__((GoalKind.STATE, GoalKind.RELATION), (*STATES, *RELATIONS))

    def normalize_word(self, text: str) -> str:
        """Return a word of an answer in lower case, with underscores as in the domain."""
        return text.strip().lower().replace("toggledon", "toggled_on")

    def map_spellings_to_predicate_names(self, domain: Domain) -> Mapping[SpellingAndArity, str]:
        """Return a mapping from predicates in the data set's goals to predicates of the domain.

        The predicate ``touching`` is mapped to ``nextto``.
        """
        arities = {**dict.fromkeys(STATES, 1), **dict.fromkeys(RELATIONS, 2)}
        return {(name, arity): DOMAIN_NAMES.get(name, name) for name, arity in arities.items()}

    def list_object_names(self, task: Task) -> tuple[str, ...]:
        """Return each object's name in goals: its instance name, or its name in the scene if it has none.

        Halves of sliced objects have no instance name.
        """
        instances = _map_object_to_instance_names(task)
        return tuple([instances.get(obj.name, obj.name) for obj in task.scene.objects])

    def list_alternatives_of_goals(self, task: Task) -> tuple[GoalAlternatives, ...]:
        """Return, for each goal in the data set, the alternative sets of conditions that reach the goal.

        If the task is not from the data set, the alternatives are computed from the task's goals.
        """
        if not isinstance(task, BehaviorTask):
            return super().list_alternatives_of_goals(task)
        names = {instance: name for name, instance in _map_object_to_instance_names(task).items()}

        @cache  # trees share one leaf for equal conditions
        def make_leaf(condition: GoalCondition) -> AndOrTreeLiteral:
            return AndOrTreeLiteral(_to_literal(condition, names))

        def make_tree_of_options(options: tuple[GroundOption, ...]) -> AndOrTree:
            return OrNode(tuple([AndNode(tuple(map(make_leaf, option))) for option in options]))

        return tuple(
            [
                GoalAlternatives("condition", None, make_tree_of_options(options))
                for options in task.record.goal_options
            ]
        )


def _map_object_to_instance_names(task: Task) -> Mapping[str, str]:
    """Return a mapping from names in actions to names in BDDL, such as ``rag_51`` to ``rag.n.01_1``.

    The mapping is empty if the data set does not have the task.
    """
    objs = task.record.objects if isinstance(task, BehaviorTask) else ()
    return {obj.name: obj.instance for obj in objs}


def _to_literal(condition: GoalCondition, name_by_instance: Mapping[str, str]) -> Literal:
    predicate, *arguments = condition
    if predicate == "not":
        return Not(_to_literal(tuple(arguments[0]), name_by_instance))
    return Atom(str(predicate), tuple(Constant(name_by_instance[str(argument)]) for argument in arguments))
