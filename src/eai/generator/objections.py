"""Why a task is not to be asked: it is none, does not say what it means, or is too near a public one.

An instruction says what it means if the goals read from it, by the sentences of `eai.generator.words`, are
those of the task.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache

import eai.logic.formula as f
from eai.abilities.goal_test import GoalTest, solves
from eai.abilities.task import Task
from eai.benchmark.lookup import LookupTable
from eai.english.english import (
    AFTER,
    AT_LEAST_ONE,
    EVERY,
    EXACTLY,
    NO,
    NUMBERS,
    OPENINGS,
    OWN,
    REQUESTS,
    SEE_TO_IT,
    SOME,
    UNTIL,
    WHILE,
    plural,
    turned,
)
from eai.errors import InputError
from eai.generator import fingerprint
from eai.generator.spec import Reason
from eai.generator.words import Words
from eai.logic.traversal import objects
from eai.world.domain import Domain

_X, _Y = f.Variable("x"), f.Variable("y")
_EVERY, _EXACTLY = "|".join(EVERY), "|".join(EXACTLY)
_QUANTIFIED = re.compile(
    rf"(?:(?P<every>{_EVERY})|(?P<no>{NO})|{AT_LEAST_ONE}|(?:{_EXACTLY}) (?P<number>\w+)) (?P<noun>.+)"
)
_INNER = re.compile("|".join([rf"{SOME} (.+)", *(own.format(a="an?", noun="(.+)") for own in OWN)]))
_TAKEN = re.compile(r"the action (\w+) has been taken on (.+)")
_ACTIONS = re.compile(r"the action (\w+(?: or \w+)*) has been taken")


class _Reader:
    """Reads the instructions about one scene."""

    def __init__(self, words: Words) -> None:
        self._words = words
        self._objects = {words.name(thing.name): thing.name for thing in words.scene.objects}
        self._categories = {noun: category for category, noun in words.nouns.items()}
        self._plurals = {plural(noun): category for category, noun in words.nouns.items()}
        self._counts = {word: number for number, word in NUMBERS.items()}

    def goals(self, instruction: str) -> tuple[f.Formula, ...]:
        """The goals that an instruction says.

        Raises:
            InputError: it is none, or has several meanings.
        """
        opening = next((o for o in (*OPENINGS, *REQUESTS) if instruction.startswith(f"{o} ")), None)
        if opening is None or not instruction.endswith("."):
            raise InputError("expected one of the openings, and a full stop")
        text = instruction[len(opening) + 1 : -1]
        *clauses, last = text.split(", ") if ", and " in text else text.split(" and ")
        read = self._request if opening in REQUESTS else self._statement
        return tuple(map(read, (*clauses, last.removeprefix("and "))))

    def _request(self, text: str) -> f.Formula:
        """What to do, or to see to."""
        if text.startswith(f"{SEE_TO_IT} "):
            return self._statement(text.removeprefix(f"{SEE_TO_IT} "))
        english = self._words.english
        meanings = [
            meaning
            for negated, requests in ((False, english.asks), (True, english.denies))
            for predicate, several in requests.items()
            for request in several
            for said in _matched(request, text)
            for meaning in self._meaning(predicate, said, negated=negated, request=True)
        ]
        return _one(meanings, text)

    def _statement(self, text: str) -> f.Formula:
        """What is to be so."""
        actions = _ACTIONS.fullmatch(text)
        if actions is not None:
            return f.Or(tuple(map(f.Occurs, actions[1].split(" or "))))
        over_time = next((word for word in (WHILE, UNTIL, AFTER) if f" {word} " in text), None)
        if over_time is not None:
            one, other = text.split(f" {over_time} ")
            return self._over_time(over_time, one, other)
        is_choice = text.startswith("either ")
        return _one(self._either(text.removeprefix("either ")) if is_choice else self._said(text), text)

    def _over_time(self, word: str, one: str, other: str) -> f.Formula:
        """Return the meaning of two sentences joined by a word."""
        if word == WHILE:
            return f.Always(f.Not(f.And((_one(self._said(one, never=True), one), self._statement(other)))))
        if word == AFTER:
            return f.Then((self._statement(other), self._statement(one)))
        taken = _TAKEN.fullmatch(other)
        if taken is None:
            return f.Until(self._statement(one), self._statement(other))
        names = [self._objects.get(name) for name in taken[2].split(" with ")]
        return f.Until(
            self._statement(one), f.Occurs(taken[1], tuple([f.Constant(n) for n in names if n is not None]))
        )

    def _either(self, text: str) -> Iterator[f.Formula]:
        for place in re.finditer(" or ", text):
            for first in self._said(text[: place.start()]):
                yield from (f.Or((first, second)) for second in self._said(text[place.end() :]))

    def _said(self, text: str, *, never: bool = False) -> Iterator[f.Formula]:
        """All that a sentence may mean, or one of what is never so may say that it is not."""
        forms = ((False, False),) if never else ((False, False), (True, False), (False, True))
        for predicate in self._words.arities:
            for sentence in self._words.sentences(predicate):
                for negated, several in forms:
                    form = turned(sentence, negated=negated, several=several, never=never)
                    for said in _matched(form, text):
                        yield from self._meaning(predicate, said, negated=negated, several=several)

    def _meaning(
        self,
        predicate: str,
        said: Sequence[str],
        *,
        negated: bool,
        several: bool = False,
        request: bool = False,
    ) -> Iterator[f.Formula]:
        """Return the meaning of a sentence that says a predicate of these, or asks for it."""
        named = [self._objects.get(word) for word in said]
        rest = tuple([f.Constant(name) for name in named[1:] if name is not None])
        is_ground = len(rest) == len(said) - 1

        def atom(*terms: f.Term) -> f.Formula:
            return f.Not(f.Atom(predicate, terms)) if negated else f.Atom(predicate, terms)

        if named[0] is not None:
            if is_ground and not several:
                yield atom(f.Constant(named[0]), *rest)
            return
        found = _QUANTIFIED.fullmatch(said[0])
        if found is None:
            return
        number, noun = found["number"], found["noun"]
        count = (
            None
            if number is None
            else self._counts.get(number) or (int(number) if number.isdigit() else None)
        )
        category = (self._plurals if several else self._categories).get(noun)
        if category is None or several != (count not in (None, 1)):
            return
        x = f.Variable("x", category)
        if is_ground:
            yield from _quantified(found, count, x, atom(_X, *rest), negated=negated, request=request)
        elif found["every"] and not negated:
            inner = _INNER.fullmatch(said[1])
            target = None if inner is None else self._categories.get(next(filter(None, inner.groups())))
            if inner is not None and target is not None:
                y = f.Variable("y", target)
                yield f.ForAll(x, f.Exists(y, atom(_X, _Y))) if inner[1] else f.ForPairs(x, y, atom(_X, _Y))


def _quantified(
    found: re.Match[str], count: int | None, x: f.Variable, body: f.Formula, *, negated: bool, request: bool
) -> Iterator[f.Formula]:
    """What is said of things of a kind; of "every ... is not", nobody knows what it means."""
    if found["every"]:
        if request or not negated:
            yield f.ForAll(x, body)
    elif found["no"] or count is not None:
        if not request and not negated:
            yield f.ForAll(x, f.Not(body)) if count is None else f.Exactly(count, x, body)
    elif found["number"] is None:
        yield f.Exists(x, body)


@cache
def _pattern(sentence: str) -> re.Pattern[str]:
    form = re.escape(sentence)
    return re.compile(form.replace(r"\{x\}", "(?P<x>.+)").replace(r"\{y\}", "(?P<y>.+)"))


def _matched(sentence: str, text: str) -> Iterator[Sequence[str]]:
    """What stands in a text for the objects of a sentence, if it is that sentence."""
    found = _pattern(sentence).fullmatch(text)
    if found is not None:
        named = found.groupdict()
        yield [named[name] for name in "xy" if name in named]


def _one(meanings: Iterable[f.Formula], text: str) -> f.Formula:
    """The one meaning of a sentence."""
    found = list(meanings)
    if len(found) != 1:
        raise InputError(f"expected a sentence with one meaning, found {len(found)} of {text!r}")
    return found[0]


class Objections:
    """Finds objections to tasks.

    Args:
        domain: whose world they are in.
        public: its benchmark's own tasks.
        by_place: whether instructions are to name nothing.
    """

    def __init__(self, domain: Domain, public: Sequence[Task], *, by_place: bool) -> None:
        self._domain, self._by_place = domain, by_place
        self._public = {
            fingerprint.of_goals([goal.formula for goal in task.goals], task.scene) for task in public
        }
        self._table = LookupTable(public, domain)

    def to(self, task: Task, words: Words, least: int, most: int) -> Reason | None:
        """Why a task in these words, with a certificate that is to be about so long, is not to be asked."""
        if len(task.script) < least:
            return Reason.TOO_SHORT
        if len(task.script) > most:
            return Reason.TOO_LONG
        reached = zip(task.goals, GoalTest(task).reached(task.initial, ()), strict=True)
        if any(holds for each, holds in reached if not each.is_over_time):
            return Reason.HOLDS_ALREADY
        if not solves(self._domain, task, task.script):
            return Reason.NO_CERTIFICATE
        if (reason := self._objection_to_words(task, words)) is not None:
            return reason
        if fingerprint.of_task(task)[0] in self._public:
            return Reason.PUBLIC
        if solves(self._domain, task, self._table.plan(task)):
            return Reason.PUBLIC_PLAN
        return None

    def _objection_to_words(self, task: Task, words: Words) -> Reason | None:
        """The instruction names what it is not to name, or, read again, does not give the goals back."""
        goals = tuple([goal.formula for goal in task.goals])
        named = (name for goal in goals for name in objects(goal))
        if self._by_place and not all(map(words.is_told, named)):
            return Reason.NAMELESS
        try:
            return None if _Reader(words).goals(task.instruction) == goals else Reason.AMBIGUOUS
        except InputError:
            return Reason.AMBIGUOUS
