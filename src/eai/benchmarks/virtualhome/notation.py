"""The notations of goals and subgoals in answers to VirtualHome's prompts.

Goals name objects by class, because their prompts show no ids. Subgoals name objects by class and id.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from eai.abilities.answer_schema import Schema, make_list_schema, make_object_schema, make_text_schema
from eai.abilities.answer_text import JsonObject, read_json
from eai.abilities.notation.goals import (
    SECTIONS,
    AnswerGoalSections,
    GoalNotation,
    IllFormed,
    SpellingAndArity,
    WrittenGoal,
    WrittenGoals,
    make_goal_sections_format,
)
from eai.abilities.notation.subgoals import (
    SubgoalNotation,
    WrittenSubgoals,
    read_subgoals_from_json_output_list,
)
from eai.abilities.verdict import Unreadable
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION
from eai.logic.signature import FormulaSignature
from eai.tasks.lexicon import FormulaNameLexicon, collect_names_of_objects_and_classes
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.state import Scene

FIELDS = {
    GoalKind.STATE: ("name", "state"),
    GoalKind.RELATION: ("from_name", "relation", "to_name"),
    GoalKind.ACTION: ("action",),
}
"""Section of an answer -> required fields of each goal in this section.

Actions may also have a description, which is not scored.
"""

_NOTHING = JsonObject(())


class VirtualHomeGoalNotation(GoalNotation):
    """Goals in three sections of a JSON object, which has at least one section.

    The object may be anywhere in the text. A section that is missing or null counts as empty, and an empty
    goal in a section is ignored. Goals name classes, and so cannot distinguish objects of one class. The data
    set's own goals get the full score nevertheless.
    """

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """Return the goals in an answer, or the reason why the answer cannot be read."""
        reading = read_json(text, _FORM)
        if isinstance(reading, Unreadable):
            return reading
        sections = dict(reading.value.members)
        entries = [
            entry for kind in FIELDS for entry in _read_goals_of_section(kind, sections.get(SECTIONS[kind]))
        ]
        return WrittenGoals.from_entries(entries, reading)

    def write(self, goals: Iterable[WrittenGoal]) -> tuple[str, ...]:
        """Return a JSON object for each goal, with its kind (such as ``node goals``) as key."""
        return tuple(json.dumps({SECTIONS[kind]: entry}) for kind, entry in map(_get_kind_and_fields, goals))

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return one answer with all goals in order, each in its section."""
        sections: dict[str, list[object]] = {key: [] for key in SECTIONS.values()}
        for part in answer_parts:
            for key, entry in json.loads(part).items():
                sections[key].append(entry)
        return json.dumps(sections, indent=1)

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """Return the JSON schema of an answer with a list of goals in each section of `SECTIONS`.

        The fields of a goal depend on the section. An action goal also has a description.
        """
        arities = self.map_spellings_to_predicate_names(domain)
        states, relations = [[word for word, arity in arities if arity == number] for number in (1, 2)]
        name = make_text_schema(words)
        entries = {
            GoalKind.STATE: {"name": name, "state": make_text_schema(states)},
            GoalKind.RELATION: {"from_name": name, "relation": make_text_schema(relations), "to_name": name},
            GoalKind.ACTION: {
                "action": make_text_schema(domain.operator_arities),
                "description": make_text_schema(),
            },
        }
        return make_object_schema(
            {SECTIONS[kind]: make_list_schema(make_object_schema(fields)) for kind, fields in entries.items()}
        )

    def map_spellings_to_predicate_names(self, domain: Domain) -> Mapping[SpellingAndArity, str]:
        """Return a mapping from pairs (word in goals, number of its objects) to names of predicates."""
        states = [p for p in domain.vocabulary.predicates if p.arity == 1 and p.visible and not p.static]
        return {
            **{(state.name, 1): state.name for state in states},
            **{(spelling, 2): predicate for spelling, predicate in PREDICATE_OF_RELATION.items()},
        }

    def list_object_names(self, task: Task) -> tuple[str, ...]:
        """Return the class of each object of a task, because goals name objects by class."""
        return tuple([obj.category for obj in task.scene.objects])


def make_goal_from_json_field_values(fields: list[str]) -> WrittenGoal:
    """Return the goal with the given fields: three for a relation, two for a state, one for an action."""
    if len(fields) == 3:
        return WrittenGoal(fields[1], (fields[0], fields[2]))
    if len(fields) == 2:
        return WrittenGoal(fields[1], (fields[0],))
    return WrittenGoal(fields[0].upper(), is_action=True)


def _find_section_error(value: object) -> str | None:
    """Return a description of the error in a JSON object with sections of goals, or None."""
    return None if not isinstance(value, JsonObject) else _find_unknown_section(value.members)


def _find_unknown_section(members: Sequence[tuple[str, object]]) -> str | None:
    times = Counter([key for key, _ in members])
    lists = [key for key, value in members if isinstance(value, list | JsonObject)]
    repeated = [key for key in lists if times[key] > 1]
    if repeated:
        return f'the section "{repeated[0]}" occurs twice'
    return next((f'there is no section "{key}"' for key in lists if key not in SECTIONS.values()), None)


def _get_goal_sections_if_valid(sections: AnswerGoalSections) -> AnswerGoalSections | None:
    """Return the sections of goals in an answer, or None if it has no section or an unknown section."""
    has_section = any(key in SECTIONS.values() for key, _ in sections.members)
    return sections if has_section and _find_unknown_section(sections.members) is None else None


def _is_name_of_predicate_or_action(text: str) -> bool:
    domain = virtualhome.make_domain_with_checks_in_paper_order()
    is_predicate = text in PREDICATE_OF_RELATION or domain.vocabulary.find_arity(text) is not None
    return is_predicate or text.upper() in domain.operator_arities


_FORM = make_goal_sections_format(
    _get_goal_sections_if_valid, _find_section_error, _is_name_of_predicate_or_action
)


def _read_goals_of_section(kind: GoalKind, section: object) -> list[WrittenGoal | IllFormed]:
    if not isinstance(section, list):
        return [] if section is None else [(kind, str(section))]
    return [_read_goal(FIELDS[kind], entry) or (kind, str(entry)) for entry in section if entry != _NOTHING]


def _read_goal(field_names: tuple[str, ...], value: object) -> WrittenGoal | None:
    """Return the goal that a JSON value states, or None if a field is missing or a key occurs twice."""
    if not isinstance(value, JsonObject) or value.repeated_key is not None:
        return None
    members = dict(value.members)
    fields = [field for name in field_names if isinstance(field := members.get(name), str)]
    return make_goal_from_json_field_values(fields) if len(fields) == len(field_names) else None


def _get_kind_and_fields(goal: WrittenGoal) -> tuple[GoalKind, dict[str, str]]:
    if goal.is_action:
        entry = {"action": goal.predicate, "description": goal.predicate.lower()}
        return GoalKind.ACTION, entry
    name, *others = goal.names
    kind = GoalKind.RELATION if others else GoalKind.STATE
    return kind, dict(zip(FIELDS[kind], (name, goal.predicate, *others), strict=True))


SUBGOAL_ACTIONS = (
    "DRINK",
    "EAT",
    "CUT",
    "TOUCH",
    "LOOKAT",
    "WATCH",
    "READ",
    "TYPE",
    "PUSH",
    "PULL",
    "MOVE",
    "SQUEEZE",
    "SLEEP",
    "WAKEUP",
    "RINSE",
    "SCRUB",
    "WASH",
    "WIPE",
    "GRAB",
    "SWITCHOFF",
)
"""The actions that the paper's package allows in subgoals (``resources/vocabulary.json``)."""

MISSING_ACTION = "POUR"
"""Action that goals of five tasks require, although it is not in the vocabulary of the paper's package."""


class VirtualHomeSubgoalNotation(SubgoalNotation):
    """Subgoals in the words of VirtualHome's prompts. Objects are named by id (``soap.1002``) or by class.

    Args:
        actions: names of the actions that subgoals may contain.
    """

    def __init__(self, actions: Sequence[str] = (*SUBGOAL_ACTIONS, MISSING_ACTION)) -> None:
        super().__init__(virtualhome.make_domain_with_checks_in_paper_order())
        self._actions: dict[str, int | None] = {
            operator.name: operator.arity for operator in self.domain.operators if operator.name in actions
        }
        self._predicates: dict[str, int | None] = {
            p.name: p.arity for p in self.domain.vocabulary.predicates if p.visible
        }

    def get_domain_for_executing_subgoals(self) -> Domain:
        """Return the domain for subgoals, which has an additional action for switching hands."""
        return virtualhome.make_domain_with_switch_hands_action()

    def make_lexicon_of_names_in_subgoals(self, scene: Scene) -> FormulaNameLexicon:
        """Return the names in formulas about a scene: objects as the data set names them, or by class."""
        names = collect_names_of_objects_and_classes(scene.index, scene)
        return FormulaNameLexicon(
            scene, FormulaSignature(self._predicates, self._actions, names), scene.index
        )

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """Return the subgoals in an answer, or the reason why the answer cannot be read.

        Actions without objects need no brackets.
        """
        return read_subgoals_from_json_output_list(text, self._arities, ("actions_to_include",))

    @cached_property
    def _arities(self) -> Mapping[str, int | None]:
        return {**self._predicates, **self._actions}

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the subgoals as one answer."""
        answer = {"necessity_to_use_action": "no", "actions_to_include": [], "output": list(answer_parts)}
        return json.dumps(answer, indent=1)

    def make_json_schema_of_answer(self) -> Schema:
        """Return the schema of the fields for which the published prompts ask."""
        return make_object_schema(
            {
                "necessity_to_use_action": make_text_schema(("yes", "no")),
                "actions_to_include": make_list_schema(make_text_schema(self._actions)),
                "output": make_list_schema(make_text_schema()),
            }
        )
