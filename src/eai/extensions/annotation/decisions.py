"""Make, save and apply a user's decisions about the goals of all tasks that share a title.

A demonstration is a plan that the data set records for a task with the title. A pattern is a kind of change,
such as ``ON(lamp)``, that demonstrations make. A user decides which patterns the title requires as goals. The
decisions are in a TOML file, which people may also edit by hand:

    without = ["NEXT_TO"]

    [title."Wash clothes"]
    dropped = ["CLOSED(cupboard)"]
    candidates = [
      [
        ["ON(washing_machine)"],
        ["ONTOP({GRABBABLE, MOVABLE, CREAM}, washing_machine)", "ONTOP(soap, washing_machine)"],
      ],
    ]

Patterns of the predicates in ``without`` are not counted. The title does not require patterns in ``dropped``.
A candidate is a possible meaning of the title: a list of entries, which must all be met. An entry is a list
of alternative patterns; at least one of them must be met. The example has one candidate with two entries.
Patterns name an object by its class or by all its properties: ``ON(washing_machine)`` is a state,
``ONTOP({GRABBABLE, MOVABLE}, washing_machine)`` a relation, ``do TOUCH`` an action.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TypeAlias

from eai.base.errors import InputError, did_you_mean, prefix_errors_with_location
from eai.base.files import format_toml_text, write_files_atomically
from eai.base.grouping import group_pairs
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.logic.ltl_printer import format_ltl
from eai.tasks.options import Options
from eai.tasks.source import DataMistake
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary

_ACTION_PREFIX = "do "
_NAME_REGEX = r"[^\s(){},]+"
_KIND_REGEX = rf"(?:{_NAME_REGEX}|\{{[^{{}}]*\}})"
_PATTERN_REGEX = re.compile(rf"({_NAME_REGEX})\((\s*{_KIND_REGEX}\s*(?:,\s*{_KIND_REGEX}\s*)*),?\)")


@dataclass(frozen=True, slots=True)
class _ObjectKindByClassOrProperties:
    """A kind of object: all objects of a class, or all objects with exactly the given properties.

    Attributes:
        name: the class; empty if properties are given.
        properties: the properties of the objects, in the order in which they were written. Equality ignores
            the order.
    """

    name: str = ""
    properties: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _ObjectKindByClassOrProperties)
            and self._comparison_key == other._comparison_key
        )

    def __hash__(self) -> int:
        return hash(self._comparison_key)

    @property
    def _comparison_key(self) -> tuple[str, frozenset[str]]:
        return self.name, frozenset(self.properties)

    def __str__(self) -> str:
        return self.name or "{" + ", ".join(self.properties) + "}"


@dataclass(frozen=True, slots=True)
class GoalPattern:
    """A form of goal: a state of one kind of object, a relation between several kinds, or an action.

    Attributes:
        name: name of the predicate or action.
        kinds: kinds of the predicate's objects; empty for an action.
    """

    name: str
    kinds: tuple[_ObjectKindByClassOrProperties, ...] = ()

    @property
    def is_action(self) -> bool:
        """Whether the pattern stands for an action, not for a fact."""
        return not self.kinds

    def __str__(self) -> str:
        if self.is_action:
            return _ACTION_PREFIX + self.name
        return f"{self.name}({', '.join(map(str, self.kinds))})"


AlternativePatterns: TypeAlias = tuple[GoalPattern, ...]
"""Alternative patterns (forms of goal). A demonstration (recorded plan) must meet at least one of them.

A possible meaning of a task title (`GoalTemplate`) is a tuple of `AlternativePatterns`.
"""


def parse_pattern(text: str) -> GoalPattern:
    """Parse a pattern (a form of goal), such as ``ON(lamp)``.

    Raises:
        InputError: the text is not a pattern.
    """
    if text.startswith(_ACTION_PREFIX) and text.removeprefix(_ACTION_PREFIX).strip():
        return GoalPattern(text.removeprefix(_ACTION_PREFIX).strip())
    atom = _PATTERN_REGEX.fullmatch(text.strip())
    if atom is None:
        raise InputError(
            f"{text!r}: expected a pattern such as ON(lamp), ONTOP({{GRABBABLE, MOVABLE}}, table) or do TOUCH"
        )
    return GoalPattern(atom[1], tuple(map(_parse_object_kind, re.findall(_KIND_REGEX, atom[2]))))


def _parse_object_kind(text: str) -> _ObjectKindByClassOrProperties:
    words = [word.strip() for word in text.strip("{}").split(",")]
    if text.startswith("{"):
        return _ObjectKindByClassOrProperties(properties=tuple(filter(None, words)))
    return _ObjectKindByClassOrProperties(text)


@dataclass(frozen=True, slots=True)
class ChangesMadeByDemonstration:
    """The changes that a demonstration (a recorded plan for a task) makes, and its actions.

    Attributes:
        task: the task of the demonstration.
        facts: all facts about single objects with a changed state, and all new relations. They have the order
            of predicates in the vocabulary, then of objects in the scene.
        actions: names of the plan's operators, in order.
    """

    task: Task
    facts: tuple[Fact, ...]
    actions: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The scene, which holds the objects of the task."""
        return self.task.scene

    def find_matching_facts(self, patterns: AlternativePatterns) -> Iterator[Fact]:
        """Yield the changed facts that fit at least one of some patterns, such as ``ON(lamp)``, in order."""
        return (
            fact for fact in self.facts if any(self._matches_pattern(fact, pattern) for pattern in patterns)
        )

    def _matches_pattern(self, fact: Fact, pattern: GoalPattern) -> bool:
        if fact.predicate != pattern.name or len(fact.arguments) != len(pattern.kinds):
            return False
        pairs = zip(fact.arguments, pattern.kinds, strict=True)
        return all(
            self.make_object_kind_from_class(object_index) == kind
            if kind.name
            else self.make_object_kind_from_properties(object_index) == kind
            for object_index, kind in pairs
        )

    def make_object_kind_from_class(self, object_index: int) -> _ObjectKindByClassOrProperties:
        """Return a description of an object by its class; it fits all objects of this class."""
        return _ObjectKindByClassOrProperties(self.scene.objects[object_index].category)

    def make_object_kind_from_properties(self, object_index: int) -> _ObjectKindByClassOrProperties:
        """Return a description of an object by its properties (visible static predicates).

        It fits all objects with exactly these properties.
        """
        initial = self.task.initial
        names = list_visible_static_unary_predicates(self.scene.vocabulary)
        return _ObjectKindByClassOrProperties(
            properties=tuple(name for name in names if initial.has(name, object_index))
        )


def find_changes_made_by_demonstration(task: Task, domain: Domain) -> ChangesMadeByDemonstration:
    """Return what a task's demonstration (its recorded plan) changes from the initial to the final state.

    The final state is in the data set, or results from executing the plan.

    Raises:
        InputError: the task has no plan, or the plan cannot be executed.
    """
    if not task.script:
        raise InputError(f"{task.id}: the task has no plan, so it is no demonstration")
    final = _find_final_state_of_demonstration(task, domain)
    changed = _find_changed_objects_mask(task.initial, final)
    predicates = task.scene.vocabulary.predicates
    facts = (
        fact
        for fact in final.facts()
        if fact.arguments
        and fact.predicate in _list_predicate_names(predicates, len(fact.arguments), static=False)
        if (
            changed >> fact.arguments[0] & 1
            if len(fact.arguments) == 1
            else not task.initial.has(fact.predicate, *fact.arguments)
        )
    )
    return ChangesMadeByDemonstration(task, tuple(facts), tuple(action.operator for action in task.script))


def _find_final_state_of_demonstration(task: Task, domain: Domain) -> State:
    if task.annotated_final is not None:
        return task.annotated_final
    done = execute_plan(domain, task.initial, task.script)
    if done.failure is not None:
        step = len(done.executed_actions) + 1
        raise InputError(
            f"{task.id}: step {step} of the plan cannot be executed; "
            "goals are derived from executed plans, so correct or leave out this plan"
        )
    return done.final_state


def _find_changed_objects_mask(before: State, after: State) -> int:
    """Return the objects with a changed state, as a bit mask. Changes of relations do not count."""
    mask = 0
    for name in _list_predicate_names(before.scene.vocabulary.predicates, 1, static=False):
        mask |= before.mask(name) ^ after.mask(name)
    return mask


def list_visible_static_unary_predicates(vocabulary: Vocabulary) -> tuple[str, ...]:
    """Return the names of the predicates that describe properties of objects, in the order of declaration."""
    return _list_predicate_names(vocabulary.predicates, 1, static=True)


@cache
def _list_predicate_names(predicates: tuple[Predicate, ...], arity: int, *, static: bool) -> tuple[str, ...]:
    return tuple(p.name for p in predicates if p.arity == arity and p.static is static and p.visible)


def count_patterns(
    differences: Iterable[ChangesMadeByDemonstration], ignored_predicates: Iterable[str]
) -> Counter[GoalPattern]:
    """Return how many changes in all demonstrations (recorded plans) fit each pattern, such as ``ON(lamp)``.

    The result first lists states and relations whose objects are all named by class. Then it lists relations
    again, with the properties of one object in place of its class. The agent is always named by its class.

    Args:
        differences: the changes of the demonstrations of one task title.
        ignored_predicates: names of predicates not counted, because they hold for too many objects.
    """
    left_out = frozenset(ignored_predicates)
    exact: Counter[GoalPattern] = Counter()
    wild: Counter[GoalPattern] = Counter()
    for changes in differences:
        for fact in changes.facts:
            if fact.predicate not in left_out:
                classes = tuple(map(changes.make_object_kind_from_class, fact.arguments))
                exact[GoalPattern(fact.predicate, classes)] += 1
                wild.update(_generalize_fact(changes, fact.predicate, fact.arguments))
    return exact + wild


def _generalize_fact(
    changes: ChangesMadeByDemonstration, name: str, object_indices: tuple[int, ...]
) -> Iterator[GoalPattern]:
    if len(object_indices) < 2:
        return
    for end, object_index in enumerate(object_indices):
        if object_index != changes.scene.agent:
            kinds = [changes.make_object_kind_from_class(other) for other in object_indices]
            kinds[end] = changes.make_object_kind_from_properties(object_index)
            yield GoalPattern(name, tuple(kinds))


GoalTemplate: TypeAlias = tuple[AlternativePatterns, ...]
"""One possible meaning of a task title: a tuple of entries, which must all be met.

An entry is a tuple of alternative patterns. A demonstration (a recorded plan) meets an entry of states and
relations, such as ``ON(lamp)``, if one of its changes fits one of the patterns. It meets an entry of actions
if it contains one of the actions. Entries of actions must be met in the order of the template.
"""


def find_index_of_first_met_template(
    candidates: Sequence[GoalTemplate], changes: ChangesMadeByDemonstration
) -> int | None:
    """Return the index of the first possible meaning of a task title that a demonstration meets, or None.

    A demonstration is a plan that the data set records for a task with the title. A meaning is a
    template of goals, with conditions on the changes that the plan makes (`is_goal_template_met`).
    """
    return next(
        (number for number, candidate in enumerate(candidates) if is_goal_template_met(candidate, changes)),
        None,
    )


def is_goal_template_met(template: GoalTemplate, changes: ChangesMadeByDemonstration) -> bool:
    """Whether a demonstration (a recorded plan) meets one possible meaning of its task title.

    For each entry of the template, the plan must make a change that fits the entry, or contain an action of
    the entry. The actions must come in the order of the entries. No plan meets a template without entries.
    """
    rest = iter(changes.actions)
    return bool(template) and all(
        any(action in {pattern.name for pattern in entry} for action in rest)
        if entry[0].is_action
        else any(changes.find_matching_facts(entry))
        for entry in template
    )


def make_goals_from_template(changes: ChangesMadeByDemonstration, template: GoalTemplate) -> tuple[Goal, ...]:
    """Turn one meaning of a task's title into goals about the objects of this task.

    A template is a list of patterns (forms of goal). Goals are the facts that match a pattern and hold after
    the demonstration (recorded plan), and the actions of the template. States come first, then relations,
    then actions.
    """
    conditions = [entry for entry in template if not entry[0].is_action]
    facts = dict.fromkeys(fact for entry in conditions for fact in changes.find_matching_facts(entry))
    states = [_make_goal(fact, changes.scene) for fact in facts if len(fact.arguments) == 1]
    relations = [_make_goal(fact, changes.scene) for fact in facts if len(fact.arguments) > 1]
    actions = [
        Goal(GoalKind.ACTION, Or(tuple(Occurs(pattern.name) for pattern in entry)))
        for entry in template
        if entry[0].is_action
    ]
    return (*states, *relations, *actions)


def _make_goal(fact: Fact, scene: Scene) -> Goal:
    things = tuple(Constant(scene.objects[i].name) for i in fact.arguments)
    return Goal(GoalKind.STATE if len(things) == 1 else GoalKind.RELATION, Atom(fact.predicate, things))


@dataclass(frozen=True, slots=True)
class UserGoalDecisionsForTaskTitle:
    """A user's decisions about the goals of all tasks with one title.

    Attributes:
        candidates: possible meanings of the title, in the order in which they are tried.
        dropped: patterns, such as ``ON(lamp)``, that fit changes in recorded plans for the title, but that
            the title does not require.
    """

    candidates: tuple[GoalTemplate, ...] = ()
    dropped: tuple[GoalPattern, ...] = ()

    @property
    def decided_patterns(self) -> frozenset[GoalPattern]:
        """All patterns, such as ``ON(lamp)``, that the user kept or dropped for the task title."""
        entries = [entry for candidate in self.candidates for entry in candidate]
        return frozenset(self.dropped).union(*entries)


class _TaskTitleUserDecisionsTomlTable(Options):
    """A user's decisions about one task title (`UserGoalDecisionsForTaskTitle`), as a table in a TOML file.

    Attributes:
        candidates: possible meanings of the title, in the order in which they are tried.
        dropped: patterns that the title does not require.
    """

    candidates: tuple[tuple[tuple[str, ...], ...], ...] = ()
    dropped: tuple[str, ...] = ()


class _UserDecisionsByTaskTitleTomlFile(Options):
    """The content of a TOML file of a user's decisions about task titles.

    Attributes:
        without: names of predicates. Changes of their facts are not counted in recorded plans.
        title: decisions about each task title.
    """

    without: tuple[str, ...] = ()
    title: Mapping[str, _TaskTitleUserDecisionsTomlTable] = {}


def read_ignored_predicates_and_user_decisions(
    path: Path,
) -> tuple[tuple[str, ...], dict[str, UserGoalDecisionsForTaskTitle]]:
    """Read from a TOML file which goals a user chose for tasks with the same title.

    Returns:
        The names of the predicates whose patterns are not counted, and the user's decisions by task title.
        Both are empty if the file does not exist.

    Raises:
        InputError: the file does not hold decisions. The message names the faulty key.
    """
    if not path.exists():
        return (), {}
    content, titles = _UserDecisionsByTaskTitleTomlFile.read_file(path), {}
    for name, table in content.title.items():
        with prefix_errors_with_location(f"{path}: title {name!r}"):
            candidates = tuple(
                tuple(map(_parse_alternative_patterns, entries)) for entries in table.candidates
            )
            titles[name] = UserGoalDecisionsForTaskTitle(candidates, tuple(map(parse_pattern, table.dropped)))
    return content.without, titles


def _parse_alternative_patterns(texts: Sequence[str]) -> AlternativePatterns:
    patterns = tuple(map(parse_pattern, texts))
    if not patterns:
        raise InputError("candidates: a list of patterns is empty; expected at least one pattern")
    if len({pattern.is_action for pattern in patterns}) > 1:
        raise InputError(
            f"{' or '.join(texts)}: an action cannot be an alternative to a state or relation; list it alone"
        )
    return patterns


def write_user_goal_decisions_by_task_title(
    path: Path,
    ignored_predicates: Sequence[str],
    decisions_by_title: Mapping[str, UserGoalDecisionsForTaskTitle],
) -> None:
    """Write a user's decisions about the goals of task titles to a TOML file.

    An interruption leaves either the old or the new content.

    Raises:
        InputError: the file cannot be written.
    """
    write_files_atomically({path: format_user_decisions_as_toml(ignored_predicates, decisions_by_title)})


def format_user_decisions_as_toml(
    ignored_predicates: Sequence[str], decisions_by_title: Mapping[str, UserGoalDecisionsForTaskTitle]
) -> str:
    """Return a user's decisions about the goals of task titles as TOML, with one line for each entry."""
    lines = [f"without = {_format_as_toml_string_list(ignored_predicates)}"]
    for name, chosen in decisions_by_title.items():
        lines += [
            "",
            f"[title.{format_toml_text(name)}]",
            f"dropped = {_format_as_toml_string_list(chosen.dropped)}",
            "candidates = [",
        ]
        for candidate in chosen.candidates:
            lines += ["  [", *(f"    {_format_as_toml_string_list(entry)}," for entry in candidate), "  ],"]
        lines.append("]")
    return "\n".join(lines) + "\n"


def _format_as_toml_string_list(values: Sequence[GoalPattern] | Sequence[str]) -> str:
    """Return texts as a TOML list on one line."""
    return f"[{', '.join([format_toml_text(str(value)) for value in values])}]"


HELP = """\
keep N ...      all of these patterns must be met
or N N ...      one of these patterns must be met
drop N ...      these patterns mean nothing for the title
add PATTERN     keep a pattern that is not listed, or: add do TOUCH or do PUSH
new             begin another candidate
undo            undo the last command
done            leave; every decision is already saved"""

COMMANDS = ("keep", "or", "drop", "add", "new", "undo", "done")


@dataclass(frozen=True)
class GoalPatternsOfDemonstrations:
    """The changes that demonstrations (recorded plans) of one task title share, as patterns with counts.

    Attributes:
        differences: the changes of each demonstration.
        domain: the domain of the demonstrations.
        without: names of predicates whose patterns are not counted.
    """

    differences: Sequence[ChangesMadeByDemonstration]
    domain: Domain
    without: Sequence[str] = ()

    @cached_property
    def demonstration_counts(self) -> Mapping[GoalPattern, int]:
        """Number of demonstrations (recorded plans) that make each change (pattern), most frequent first."""
        occurrences = Counter(
            each for one in self.differences for each in count_patterns([one], self.without)
        )
        order = count_patterns(self.differences, self.without)
        return {
            pattern: occurrences[pattern] for pattern in sorted(order, key=lambda each: -occurrences[each])
        }

    @cached_property
    def patterns_in_order_shown_to_user(self) -> Sequence[GoalPattern]:
        """The patterns of changed facts, such as ``ON(lamp)``, in the order of their numbers for the user.

        Numbers start at 1. Decisions to keep or drop patterns do not change the numbers.
        """
        return tuple(self.demonstration_counts)

    def find_numbers_of_undecided_patterns(self, decisions: UserGoalDecisionsForTaskTitle) -> list[int]:
        """Return the numbers, from 1 on, of the patterns that the user neither kept nor dropped."""
        decided = decisions.decided_patterns
        return [
            number
            for number, pattern in enumerate(self.patterns_in_order_shown_to_user, 1)
            if pattern not in decided
        ]


def apply_user_command_to_decisions(
    command: str, decisions: UserGoalDecisionsForTaskTitle, listing: GoalPatternsOfDemonstrations
) -> UserGoalDecisionsForTaskTitle:
    """Return a user's decisions about the goals of a task title, changed by one more command of the user.

    The commands keep or drop patterns, such as ``ON(lamp)`` (see `HELP`). The caller handles ``undo`` and
    ``done``.

    Raises:
        InputError: the command is unknown or malformed.
    """
    word, _, rest = command.strip().partition(" ")
    match word:
        case "keep":
            return _add_patterns_to_last_goal_candidate(
                decisions, [(pattern,) for pattern in _parse_pattern_numbers(rest, listing)]
            )
        case "or":
            return _add_patterns_to_last_goal_candidate(
                decisions, [tuple(_parse_pattern_numbers(rest, listing))]
            )
        case "drop":
            kept = dict.fromkeys((*decisions.dropped, *_parse_pattern_numbers(rest, listing)))
            return replace(decisions, dropped=tuple(kept))
        case "add":
            patterns = _parse_alternative_patterns([part.strip() for part in rest.split(" or ")])
            for pattern in patterns:
                _refuse_unknown_names(pattern, listing)
            return _add_patterns_to_last_goal_candidate(decisions, [patterns])
        case "new":
            return replace(decisions, candidates=(*decisions.candidates, ()))
        case _:
            raise InputError(f"{word!r} is no command: {', '.join(COMMANDS)}{did_you_mean(word, COMMANDS)}")


def _parse_pattern_numbers(text: str, listing: GoalPatternsOfDemonstrations) -> list[GoalPattern]:
    patterns = []
    for word in text.replace(",", " ").split():
        if not word.isdecimal() or not 1 <= int(word) <= len(listing.patterns_in_order_shown_to_user):
            raise InputError(
                f"{word!r}: expected a number from 1 to {len(listing.patterns_in_order_shown_to_user)}"
            )
        patterns.append(listing.patterns_in_order_shown_to_user[int(word) - 1])
    if not patterns:
        raise InputError("expected numbers of listed patterns, such as 1 3")
    return patterns


def refuse_unknown_name(pattern: GoalPattern, domain: Domain) -> None:
    """Raise an error if the domain does not declare the predicate or action of a pattern (a form of goal).

    Raises:
        InputError: the domain does not declare the name, or no action can change the predicate.
    """
    arity = len(pattern.kinds)
    if pattern.is_action:
        _refuse_unknown(pattern.name, [operator.name for operator in domain.operators], "action")
    else:
        names = [
            predicate.name
            for predicate in domain.vocabulary.predicates
            if predicate.arity == arity and not predicate.static
        ]
        _refuse_unknown(pattern.name, names, f"changing predicate of {arity}")


def _refuse_unknown_names(pattern: GoalPattern, listing: GoalPatternsOfDemonstrations) -> None:
    refuse_unknown_name(pattern, listing.domain)
    classes = {thing.category for changes in listing.differences for thing in changes.scene.objects}
    good_for = list_visible_static_unary_predicates(listing.domain.vocabulary)
    for kind in pattern.kinds:
        if kind.name:
            _refuse_unknown(kind.name, sorted(classes), "class")
        for name in kind.properties:
            _refuse_unknown(name, good_for, "property")


def _refuse_unknown(name: str, known: Sequence[str], noun: str) -> None:
    if name not in known:
        raise InputError(f"{name!r} is no {noun}{did_you_mean(name, known)}")


def _add_patterns_to_last_goal_candidate(
    decisions: UserGoalDecisionsForTaskTitle, required_patterns: Sequence[AlternativePatterns]
) -> UserGoalDecisionsForTaskTitle:
    """Return a user's decisions about a task title, with more conditions in the last candidate.

    A candidate is a possible meaning of the title. If the decisions have no candidate, the conditions make
    the first one. Each condition is a tuple of alternative patterns, such as ``ON(lamp)``.
    """
    *before, last = decisions.candidates or ((),)
    return replace(decisions, candidates=(*before, (*last, *required_patterns)))


Annotation: TypeAlias = tuple[ChangesMadeByDemonstration, int | None, tuple[Goal, ...]]
"""A demonstration (recorded plan) as three values: its changes, the index of its meaning, and its goals.

A meaning is a `GoalTemplate`. The task title has several possible meanings; the index is that of the first
meaning that the changes satisfy. If they satisfy no meaning, the index is None and the goals are empty.
"""


def group_by_title(tasks: Mapping[str, Task], title: str | None = None) -> dict[str, list[Task]]:
    """Return the tasks that have a plan, grouped by title. If a title is given, return only its tasks.

    Raises:
        InputError: the title is unknown, or no task has a plan.
    """
    groups = group_pairs((task.title, task) for task in tasks.values() if task.script)
    if title is not None and title not in groups:
        raise InputError(f"no demonstration is called {title!r}{did_you_mean(title, tuple(groups))}")
    if not groups:
        raise InputError("no task has a plan; expected tasks with recorded plans (demonstrations)")
    return groups if title is None else {title: groups[title]}


def derive_goals_from_demonstrations(
    tasks_by_title: Mapping[str, Iterable[Task]],
    domain: Domain,
    decisions_by_title: Mapping[str, UserGoalDecisionsForTaskTitle],
) -> Iterator[Annotation]:
    """Yield the changes and goals of each demonstration, and the index of the first candidate that it meets.

    A demonstration is a recorded plan. A candidate is a possible meaning of its task title, as the user
    decided. Demonstrations of one title come together.

    Raises:
        InputError: a plan cannot be executed, or a decision uses an undeclared name.
    """
    for name, tasks in tasks_by_title.items():
        candidates = decisions_by_title.get(name, UserGoalDecisionsForTaskTitle()).candidates
        for candidate in candidates:
            for pattern in (p for entry in candidate for p in entry):
                with prefix_errors_with_location(f"title {name!r}: {pattern}"):
                    refuse_unknown_name(pattern, domain)
        for changes in (find_changes_made_by_demonstration(task, domain) for task in tasks):
            number = find_index_of_first_met_template(candidates, changes)
            yield (
                changes,
                number,
                () if number is None else make_goals_from_template(changes, candidates[number]),
            )


def check_goals(annotations: Iterable[Annotation]) -> Iterator[DataMistake]:
    """Yield a finding about each task whose goals in the data set differ from the goals of its annotation.

    The goals of the annotation follow from the decisions about the meaning of the task's title.
    """
    for changes, candidate, goals in annotations:
        task = changes.task
        ours, theirs = set(goals), set(task.goals)
        if candidate is None and theirs:
            yield DataMistake(task.title, f"{task.id}: has goals, but its plan meets no candidate")
        elif ours != theirs:
            lacks = [f"lacks {format_ltl(goal.formula)}" for goal in goals if goal not in theirs]
            more = [
                f"has the further goal {format_ltl(goal.formula)}" for goal in task.goals if goal not in ours
            ]
            yield DataMistake(task.title, f"{task.id}: {', '.join([*lacks, *more])}")
