"""Decisions: what people chose as the meaning of each title, in a TOML file that they may also edit by hand.

    without = ["NEXT_TO"]

    [title."Wash clothes"]
    dropped = ["CLOSED(cupboard)"]
    candidates = [
      [
        ["ON(washing_machine)"],
        ["ONTOP({GRABBABLE, MOVABLE, CREAM}, washing_machine)", "ONTOP(soap, washing_machine)"],
      ],
    ]

A candidate is a list of entries, an entry a list of patterns of which one must be met. Patterns are what
demonstrations share of what they change: an abstract goal asks for objects by their class or by all that they
are good for. ``ON(washing_machine)`` is a state, ``ONTOP({GRABBABLE, MOVABLE}, washing_machine)`` a relation,
``do TOUCH`` an action.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TypeAlias

from eai.base.errors import InputError, did_you_mean, prefix_errors
from eai.base.files import write_whole
from eai.base.grouping import group_pairs
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.logic.ltl_printer import print_ltl
from eai.tasks.options import Options
from eai.tasks.source import Finding
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary

_DO = "do "
_NAME = r"[^\s(){},]+"
_KIND = rf"\s*({_NAME}|\{{[^{{}}]*\}})\s*"
_ATOM = re.compile(rf"({_NAME})\({_KIND}(?:,{_KIND})?,?\)")


@dataclass(frozen=True, slots=True)
class _Kind:
    """Objects of a class, or those that have exactly some properties.

    Attributes:
        name: the class; empty if it is properties that count.
        properties: what the objects are good for, in the order in which they are written; two kinds with the
            same ones are one.
    """

    name: str = ""
    properties: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Kind) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[str, frozenset[str]]:
        return self.name, frozenset(self.properties)

    def __str__(self) -> str:
        return self.name or "{" + ", ".join(self.properties) + "}"


@dataclass(frozen=True, slots=True)
class Pattern:
    """A state of one kind of object, a relation of two, or an action.

    Attributes:
        name: of the predicate or action.
        kinds: of what it is said; of an action nothing.
    """

    name: str
    kinds: tuple[_Kind, ...] = ()

    @property
    def is_action(self) -> bool:
        """Whether something is to be done."""
        return not self.kinds

    def __str__(self) -> str:
        return _DO + self.name if self.is_action else f"{self.name}({', '.join(map(str, self.kinds))})"


Entry: TypeAlias = tuple[Pattern, ...]
"""A part of an abstract goal: one of these patterns must be met."""


def read_pattern(text: str) -> Pattern:
    """The pattern that a text is.

    Raises:
        InputError: it is none.
    """
    if text.startswith(_DO) and text.removeprefix(_DO).strip():
        return Pattern(text.removeprefix(_DO).strip())
    atom = _ATOM.fullmatch(text.strip())
    if atom is None:
        raise InputError(
            f"{text!r}: expected a pattern such as ON(lamp), ONTOP({{GRABBABLE, MOVABLE}}, table) or do TOUCH"
        )
    name, *kinds = filter(None, atom.groups())
    return Pattern(name, tuple(map(_kind, kinds)))


def _kind(text: str) -> _Kind:
    words = [word.strip() for word in text.strip("{}").split(",")]
    return _Kind(properties=tuple(filter(None, words))) if text.startswith("{") else _Kind(text)


@dataclass(frozen=True, slots=True)
class Difference:
    """The changes that a demonstration makes, and its actions.

    Attributes:
        task: what was demonstrated.
        facts: all that can be said of each object of which something changed, as a fact about it alone, and
            the relations that are new; in the order of the vocabulary, then of the scene.
        actions: the operators of the plan, in order.
    """

    task: Task
    facts: tuple[Fact, ...]
    actions: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The objects."""
        return self.task.scene

    def meeting(self, entry: Entry) -> Iterator[Fact]:
        """The facts that an entry about the world asks for, in order."""
        return (fact for fact in self.facts if any(self._is(fact, pattern) for pattern in entry))

    def _is(self, fact: Fact, pattern: Pattern) -> bool:
        if fact.predicate != pattern.name or len(fact.arguments) != len(pattern.kinds):
            return False
        pairs = zip(fact.arguments, pattern.kinds, strict=True)
        return all(
            self.class_of(thing) == kind if kind.name else self.properties_of(thing) == kind
            for thing, kind in pairs
        )

    def class_of(self, thing: int) -> _Kind:
        """The class of an object."""
        return _Kind(self.scene.objects[thing].category)

    def properties_of(self, thing: int) -> _Kind:
        """The properties of an object: the visible static predicates that hold of it."""
        initial = self.task.initial
        names = properties(self.scene.vocabulary)
        return _Kind(properties=tuple(name for name in names if initial.has(name, thing)))


def difference(task: Task, domain: Domain) -> Difference:
    """The changes of a task's demonstration: of its plan, to the state that the data set says it ends in.

    Where the data set does not say, the plan is carried out.

    Raises:
        InputError: it is no demonstration: there is no plan, or it cannot be carried out.
    """
    if not task.script:
        raise InputError(f"{task.id}: no demonstration; expected a plan")
    final = _final(task, domain)
    changed = _changed(task.initial, final)
    predicates = task.scene.vocabulary.predicates
    facts = (
        fact
        for fact in final.facts()
        if fact.arguments and fact.predicate in _names(predicates, len(fact.arguments), static=False)
        if (
            changed >> fact.arguments[0] & 1
            if len(fact.arguments) == 1
            else not task.initial.has(fact.predicate, *fact.arguments)
        )
    )
    return Difference(task, tuple(facts), tuple(action.operator for action in task.script))


def _final(task: Task, domain: Domain) -> State:
    if task.annotated_final is not None:
        return task.annotated_final
    done = execute(domain, task.initial, task.script)
    if done.failure is not None:
        step = len(done.executed) + 1
        raise InputError(f"{task.id}: no demonstration; step {step} of its plan cannot be carried out")
    return done.final


def _changed(before: State, after: State) -> int:
    """The mask of objects of which something alone is otherwise."""
    found = 0
    for name in _names(before.scene.vocabulary.predicates, 1, static=False):
        found |= before.mask(name) ^ after.mask(name)
    return found


def properties(vocabulary: Vocabulary) -> tuple[str, ...]:
    """The predicates that say what an object is good for, in order."""
    return _names(vocabulary.predicates, 1, static=True)


@cache
def _names(predicates: tuple[Predicate, ...], arity: int, *, static: bool) -> tuple[str, ...]:
    return tuple(p.name for p in predicates if p.arity == arity and p.static is static and p.visible)


def frequencies(differences: Iterable[Difference], without: Iterable[str]) -> Counter[Pattern]:
    """How often each pattern occurs in all differences together.

    States and relations by class come first, then relations with one of both ends by its properties; the
    agent stays itself.

    Args:
        differences: those of one title.
        without: predicates that are not counted, because they hold of too much.
    """
    left_out = frozenset(without)
    exact: Counter[Pattern] = Counter()
    wild: Counter[Pattern] = Counter()
    for each in differences:
        for fact in each.facts:
            if fact.predicate not in left_out:
                classes = tuple(map(each.class_of, fact.arguments))
                exact[Pattern(fact.predicate, classes)] += 1
                wild.update(_generalised(each, fact.predicate, fact.arguments))
    return exact + wild


def _generalised(each: Difference, name: str, things: tuple[int, ...]) -> Iterator[Pattern]:
    if len(things) < 2:
        return
    for end, thing in enumerate(things):
        if thing != each.scene.agent:
            kinds = [each.class_of(other) for other in things]
            kinds[end] = each.properties_of(thing)
            yield Pattern(name, tuple(kinds))


Candidate: TypeAlias = tuple[Entry, ...]
"""One meaning of a title: all that it asks for; actions in the order in which they are to be taken."""


def first_met(candidates: Sequence[Candidate], found: Difference) -> int | None:
    """The number of the first candidate that a demonstration meets, from 0; None if it meets none."""
    return next((number for number, each in enumerate(candidates) if is_met(each, found)), None)


def is_met(candidate: Candidate, found: Difference) -> bool:
    """Whether a demonstration does all that is asked for, actions in the order of the entries."""
    rest = iter(found.actions)
    return all(
        any(action in {pattern.name for pattern in entry} for action in rest)
        for entry in candidate
        if entry[0].is_action
    ) and all(any(found.meeting(entry)) for entry in candidate if not entry[0].is_action)


def concrete_goals(found: Difference, candidate: Candidate) -> tuple[Goal, ...]:
    """The part of a candidate's goals that a demonstration of it reached, as goals of its own task.

    States come first, then relations, then actions.
    """
    conditions = [entry for entry in candidate if not entry[0].is_action]
    facts = dict.fromkeys(fact for entry in conditions for fact in found.meeting(entry))
    states = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 1]
    relations = [_goal(fact, found.scene) for fact in facts if len(fact.arguments) == 2]
    actions = [
        Goal(GoalKind.ACTION, Or(tuple(Occurs(pattern.name) for pattern in entry)))
        for entry in candidate
        if entry[0].is_action
    ]
    return (*states, *relations, *actions)


def _goal(fact: Fact, scene: Scene) -> Goal:
    things = tuple(Constant(scene.objects[i].name) for i in fact.arguments)
    return Goal(GoalKind.STATE if len(things) == 1 else GoalKind.RELATION, Atom(fact.predicate, things))


@dataclass(frozen=True, slots=True)
class Chosen:
    """The decisions about one title.

    Attributes:
        candidates: in the order in which they are tried.
        dropped: what means nothing.
    """

    candidates: tuple[Candidate, ...] = ()
    dropped: tuple[Pattern, ...] = ()

    @property
    def decided(self) -> frozenset[Pattern]:
        """All patterns that were kept or dropped."""
        entries = [entry for candidate in self.candidates for entry in candidate]
        return frozenset(self.dropped).union(*entries)


class _Table(Options):
    """A title as a file has it."""

    candidates: tuple[tuple[tuple[str, ...], ...], ...] = ()
    dropped: tuple[str, ...] = ()


class _File(Options):
    """A file of decisions; ``without`` names predicates that are not counted, as they hold of too much."""

    without: tuple[str, ...] = ()
    title: Mapping[str, _Table] = {}


def read_decisions(path: Path) -> tuple[tuple[str, ...], dict[str, Chosen]]:
    """The predicates that are not counted, and the decisions by title; none if there is no such file.

    Raises:
        InputError: it is not one of decisions; the message names the place.
    """
    if not path.exists():
        return (), {}
    found, titles = _File.of_file(path), {}
    for name, table in found.title.items():
        with prefix_errors(f"{path}: title {name!r}"):
            candidates = tuple(tuple(map(_entry, entries)) for entries in table.candidates)
            titles[name] = Chosen(candidates, tuple(map(read_pattern, table.dropped)))
    return found.without, titles


def _entry(texts: Sequence[str]) -> Entry:
    patterns = tuple(map(read_pattern, texts))
    if not patterns:
        raise InputError("an entry is empty")
    if len({pattern.is_action for pattern in patterns}) > 1:
        raise InputError(f"{' or '.join(texts)}: an action is no alternative to a state of the world")
    return patterns


def write_decisions(path: Path, without: Sequence[str], titles: Mapping[str, Chosen]) -> None:
    """Write decisions so that the file is whole at every moment: the old one or the new one.

    Raises:
        InputError: it cannot be written.
    """
    write_whole({path: decisions_text(without, titles)})


def decisions_text(without: Sequence[str], titles: Mapping[str, Chosen]) -> str:
    """Decisions as a file has them, an entry a line."""
    lines = [f"without = {_strings(without)}"]
    for name, chosen in titles.items():
        lines += [
            "",
            f"[title.{json.dumps(name)}]",
            f"dropped = {_strings(chosen.dropped)}",
            "candidates = [",
        ]
        for candidate in chosen.candidates:
            lines += ["  [", *(f"    {_strings(entry)}," for entry in candidate), "  ],"]
        lines.append("]")
    return "\n".join(lines) + "\n"


def _strings(values: Sequence[Pattern] | Sequence[str]) -> str:
    """A list of texts on one line; the strings of JSON are strings of TOML."""
    return json.dumps([str(value) for value in values])


HELP = """\
keep N ...      each of these must be so
or N N ...      one of these must be so
drop N ...      these mean nothing
add PATTERN     one that is not listed, or: add do TOUCH or do PUSH
new             what follows is of another candidate
undo            take the last command back
done            leave; every decision is saved at once"""

COMMANDS = ("keep", "or", "drop", "add", "new", "undo", "done")


@dataclass(frozen=True)
class Listing:
    """The patterns that the demonstrations of a title share.

    Attributes:
        differences: what each of them changes.
        domain: their world.
        without: predicates that are not counted.
    """

    differences: Sequence[Difference]
    domain: Domain
    without: Sequence[str] = ()

    @cached_property
    def counts(self) -> Mapping[Pattern, int]:
        """In how many demonstrations each pattern occurs, the most frequent first."""
        found = Counter(each for one in self.differences for each in frequencies([one], self.without))
        order = frequencies(self.differences, self.without)
        return {pattern: found[pattern] for pattern in sorted(order, key=lambda each: -found[each])}

    @cached_property
    def numbered(self) -> Sequence[Pattern]:
        """The patterns by their numbers, which stay the same whatever is decided; the first has number 1."""
        return tuple(self.counts)

    def open(self, chosen: Chosen) -> list[int]:
        """The numbers of patterns of which nothing is decided yet."""
        decided = chosen.decided
        return [number for number, pattern in enumerate(self.numbered, 1) if pattern not in decided]


def decide(command: str, chosen: Chosen, listing: Listing) -> Chosen:
    """The decisions after one more command, other than ``undo`` and ``done``.

    Raises:
        InputError: it is no command.
    """
    word, _, rest = command.strip().partition(" ")
    match word:
        case "keep":
            return _with_entries(chosen, [(pattern,) for pattern in _named(rest, listing)])
        case "or":
            return _with_entries(chosen, [tuple(_named(rest, listing))])
        case "drop":
            kept = dict.fromkeys((*chosen.dropped, *_named(rest, listing)))
            return replace(chosen, dropped=tuple(kept))
        case "add":
            patterns = _entry([part.strip() for part in rest.split(" or ")])
            for pattern in patterns:
                _refuse_strangers(pattern, listing)
            return _with_entries(chosen, [patterns])
        case "new":
            return replace(chosen, candidates=(*chosen.candidates, ()))
        case _:
            raise InputError(f"{word!r} is no command: {', '.join(COMMANDS)}{did_you_mean(word, COMMANDS)}")


def _named(text: str, listing: Listing) -> list[Pattern]:
    """The patterns of these numbers."""
    found = []
    for word in text.replace(",", " ").split():
        if not word.isdecimal() or not 1 <= int(word) <= len(listing.numbered):
            raise InputError(f"{word!r}: expected a number from 1 to {len(listing.numbered)}")
        found.append(listing.numbered[int(word) - 1])
    if not found:
        raise InputError("expected the number of a line, or several")
    return found


def refuse_unknown_name(pattern: Pattern, domain: Domain) -> None:
    """Refuse a pattern of an action, or of a predicate, that there is not.

    Raises:
        InputError: the domain does not declare it, or not as something that changes.
    """
    arity = len(pattern.kinds)
    if pattern.is_action:
        _refuse_unknown(pattern.name, [operator.name for operator in domain.operators], "action")
    else:
        names = [
            each.name for each in domain.vocabulary.predicates if each.arity == arity and not each.static
        ]
        _refuse_unknown(pattern.name, names, f"changing predicate of {arity}")


def _refuse_strangers(pattern: Pattern, listing: Listing) -> None:
    """Raise if a pattern names what is not there."""
    refuse_unknown_name(pattern, listing.domain)
    classes = {thing.category for each in listing.differences for thing in each.scene.objects}
    good_for = properties(listing.domain.vocabulary)
    for kind in pattern.kinds:
        if kind.name:
            _refuse_unknown(kind.name, sorted(classes), "class")
        for name in kind.properties:
            _refuse_unknown(name, good_for, "property")


def _refuse_unknown(name: str, known: Sequence[str], noun: str) -> None:
    if name not in known:
        raise InputError(f"{name!r} is no {noun}{did_you_mean(name, known)}")


def _with_entries(chosen: Chosen, entries: Sequence[Entry]) -> Chosen:
    """The decisions with entries in the last candidate."""
    *before, last = chosen.candidates or ((),)
    return replace(chosen, candidates=(*before, (*last, *entries)))


Annotation: TypeAlias = tuple[Difference, int | None, tuple[Goal, ...]]
"""A demonstration under decisions: what it changes, the number of the candidate that it meets, from 0,
and the goals that follow for its task; None and no goals if it meets none."""


def by_title(tasks: Mapping[str, Task], title: str | None = None) -> dict[str, list[Task]]:
    """The tasks with a plan by their titles, or those of one.

    Raises:
        InputError: there is no such title, or none has a plan.
    """
    found = group_pairs((task.title, task) for task in tasks.values() if task.script)
    if title is not None and title not in found:
        raise InputError(f"no demonstration is called {title!r}{did_you_mean(title, tuple(found))}")
    if not found:
        raise InputError("no task has a plan, which is what a demonstration is")
    return found if title is None else {title: found[title]}


def annotate(
    titles: Mapping[str, Iterable[Task]], domain: Domain, decisions: Mapping[str, Chosen]
) -> Iterator[Annotation]:
    """Each demonstration under decisions, title by title.

    Raises:
        InputError: a plan cannot be carried out, or what was decided is about what is not declared.
    """
    for name, tasks in titles.items():
        candidates = decisions.get(name, Chosen()).candidates
        for candidate in candidates:
            for pattern in (each for entry in candidate for each in entry):
                with prefix_errors(f"title {name!r}: {pattern}"):
                    refuse_unknown_name(pattern, domain)
        for found in (difference(task, domain) for task in tasks):
            number = first_met(candidates, found)
            yield found, number, () if number is None else concrete_goals(found, candidates[number])


def check(annotations: Iterable[Annotation]) -> Iterator[Finding]:
    """Where the goals of tasks are not those that follow from the decisions."""
    for found, candidate, goals in annotations:
        task = found.task
        ours, theirs = set(goals), set(task.goals)
        if candidate is None and theirs:
            yield Finding(task.title, f"{task.id}: has goals, and meets no candidate")
        elif ours != theirs:
            lacks = [f"lacks {print_ltl(goal.formula)}" for goal in goals if goal not in theirs]
            more = [f"has {print_ltl(goal.formula)} besides" for goal in task.goals if goal not in ours]
            yield Finding(task.title, f"{task.id}: {', '.join([*lacks, *more])}")
