"""Goals in English: instructions made from goals, and goals read from instructions.

An instruction is exact if the goals read from it are those of the task.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import eai.logic.formula as f
import eai.tasks.english as e
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.logic.traversal import MAX_COUNT_DIGITS
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import parameter_names

_X, _Y = f.Variable("x"), f.Variable("y")
_EVERY, _EXACTLY = "|".join(e.EVERY), "|".join(e.EXACTLY)
_QUANTIFIED = re.compile(
    rf"(?:(?P<every>{_EVERY})|(?P<no>{e.NO})|{e.AT_LEAST_ONE}|(?:{_EXACTLY}) (?P<number>\w+)) (?P<noun>.+)"
)
_NUMBER = re.compile(f"[0-9]{{1,{MAX_COUNT_DIGITS}}}")
_INNER = re.compile("|".join([rf"{e.SOME} (.+)", *(own.format(a="an?", noun="(.+)") for own in e.OWN)]))
_TAKEN = re.compile(r"the action (\w+) has been taken on (.+)")
_ACTIONS = re.compile(r"the action (\w+(?: or \w+)*) has been taken")


@dataclass(frozen=True)
class Words:
    """The words of instructions about one scene.

    Attributes:
        arities: number of arguments of each predicate of goals.
        scene: the scene.
        english: words for predicates and categories; their own names if none are given.
        seen: initial facts by which objects of one category may be distinguished.
    """

    arities: Mapping[str, int]
    scene: Scene
    english: e.English
    seen: Sequence[Fact] = ()

    @staticmethod
    def of(benchmark: Benchmark, initial: State, *, by_place: bool = False) -> Words:
        """Return the words of a benchmark for a scene; by_place describes objects by their places."""
        arity, scene = benchmark.domain.vocabulary.arity, initial.scene
        wording = benchmark.wording(Ability.ACTION_SEQUENCING)
        arities = {name: arity(name) or 0 for name in wording.predicates}
        everything = range(len(scene.objects)) if by_place else ()
        seen = [fact for each in wording.listings for fact in each.facts(initial, everything)]
        return Words(arities, scene, benchmark.notation.english, seen)

    def sentences(self, predicate: str) -> Sequence[str]:
        """Return sentences that state a predicate in the singular, such as ``{x} is on top of {y}``."""
        return e.sentences_of(predicate, self.arities[predicate], self.english)

    @cached_property
    def nouns(self) -> Mapping[str, str]:
        """The noun of each category of the scene; the category's own name if two categories share a noun."""
        found: dict[str, str] = {}
        for thing in self.scene.objects:
            made = " ".join(re.sub(r"\.n\.\d+$", "", thing.category).replace("_", " ").split())
            noun = self.english.nouns.get(thing.category, made)
            taken = any(n == noun and c != thing.category for c, n in found.items())
            found.setdefault(thing.category, thing.category if taken else noun)
        return found

    def name(self, name: str) -> str:
        """Return words for an object: ``the lamp`` if it is the only one, or its place, or its name."""
        index = self.scene.index[name]
        return self._alone(index) if self._is_alone(index) else self._by_place.get(index, name)

    def is_described(self, name: str) -> bool:
        """Whether an object can be distinguished from others without its name."""
        index = self.scene.index[name]
        return self._is_alone(index) or index in self._by_place

    @cached_property
    def apart(self) -> Mapping[int, Fact]:
        """The initial fact that distinguishes an object from others of its category, by object.

        The fact is a state that no other object of the category has, or a relation to an object that is the
        only one of its category.
        """
        described: dict[tuple[str, str, tuple[int, ...]], list[int]] = {}
        about = [fact for fact in self.seen if fact.arguments]
        for fact in sorted(about, key=lambda fact: -len(fact.arguments)):
            thing, *places = fact.arguments
            if all(map(self._is_alone, places)):
                category = self.scene.objects[thing].category
                described.setdefault((fact.predicate, category, tuple(places)), []).append(thing)
        found: dict[int, Fact] = {}
        for (predicate, _, there), (thing, *others) in described.items():
            if not others and not self._is_alone(thing):
                found.setdefault(thing, Fact(predicate, (thing, *there)))
        return found

    @cached_property
    def _by_place(self) -> Mapping[int, str]:
        return {thing: self._described(*fact) for thing, fact in self.apart.items()}

    def _described(self, predicate: str, arguments: Sequence[int]) -> str:
        thing, *there = arguments
        sentence = self.sentences(predicate)[0]
        sentence = sentence if there else f"{sentence} now"  # the state may be false at the end
        return _with_words(sentence, [f"the {self._noun_of(thing)} that", *map(self._alone, there)])

    def _alone(self, index: int) -> str:
        return f"the {self._noun_of(index)}"

    def _noun_of(self, index: int) -> str:
        return self.nouns[self.scene.objects[index].category]

    def _is_alone(self, index: int) -> bool:
        return self.scene.category(self.scene.objects[index].category).bit_count() == 1

    def instruction(self, goals: Sequence[f.Formula], rng: random.Random) -> str:
        """Return a sentence that states all goals.

        Raises:
            InputError: the sentence forms have none for the shape of a goal.
        """
        voice = e.Voice.drawn(rng)
        opening = rng.choice(e.REQUESTS if voice.requests else e.OPENINGS)
        return f"{opening} {_joined([self.clause(goal, voice) for goal in goals])}."

    def says(self, instruction: str, goals: Sequence[f.Formula]) -> bool:
        """Whether the goals read from an instruction are exactly these goals."""
        try:
            return _Reader(self).goals(instruction) == tuple(goals)
        except InputError:
            return False

    def clause(self, goal: f.Formula, voice: e.Voice = e.USUAL) -> str:
        """Return a clause of an instruction that states a goal."""
        if not voice.requests:
            return self._statement(goal, voice)
        return self._request(goal, voice) or f"{e.SEE_TO_IT} {self._statement(goal, voice)}"

    def _request(self, goal: f.Formula, voice: e.Voice) -> str | None:
        """Return a request for a goal, or None if requests cannot state it."""
        plain = _plain(goal)
        if plain is None:
            return None
        atom, negated = plain
        first = next(iter(atom.arguments), None)
        if isinstance(first, f.Constant) and self.scene.index[first.name] == self.scene.agent:
            return None  # a request to put the agent on a couch makes no sense
        several = (self.english.denies if negated else self.english.asks).get(atom.predicate)
        return None if several is None else self._filled(voice.of(several), atom, self._ranges(goal, voice))

    def _statement(self, goal: f.Formula, voice: e.Voice) -> str:
        """Return a statement of a goal, without a full stop."""
        match goal:
            case f.Or(parts) if all(isinstance(part, f.Occurs) for part in parts):
                names = [part.action for part in parts if isinstance(part, f.Occurs)]
                return f"the action {' or '.join(names)} has been taken"
            case f.Or((first, second)):
                return f"either {self._statement(first, voice)} or {self._statement(second, voice)}"
            case f.ForAll(variable, f.Not(f.Atom() as atom)):
                return self._text(atom, {variable.name: f"{e.NO} {self._noun(variable)}"}, voice)
            case f.Exactly(count, _, f.Atom() as atom):
                return self._text(atom, self._ranges(goal, voice), voice, several=count != 1)
        plain = _plain(goal)
        if plain is None:
            return self._clause_over_time(goal, voice)
        atom, negated = plain
        return self._text(atom, self._ranges(goal, voice), voice, negated=negated)

    def _clause_over_time(self, goal: f.Formula, voice: e.Voice) -> str:
        """Return a statement of a goal over time."""
        match goal:
            case f.Always(f.Not(f.And((f.Atom() as one, other)))):
                return f"{self._text(one, {}, voice, never=True)} {e.WHILE} {self._statement(other, voice)}"
            case f.Until(f.Not(f.Atom() as then), f.Occurs(action, terms)):
                named = " with ".join([self.name(term.name) for term in terms])
                taken = f"the action {action} has been taken on {named}"
                return f"{self._text(then, {}, voice, negated=True)} {e.UNTIL} {taken}"
            case f.Until(f.Not(f.Atom() as then), first):
                denied = self._text(then, {}, voice, negated=True)
                return f"{denied} {e.UNTIL} {self._statement(first, voice)}"
            case f.Then((first, then)):
                return f"{self._statement(then, voice)} {e.AFTER} {self._statement(first, voice)}"
        raise InputError(f"no sentence states a goal of the shape {type(goal).__name__}")

    def _ranges(self, goal: f.Formula, voice: e.Voice) -> dict[str, str]:
        """Return the words for each variable of a goal, such as ``every lamp``."""
        every = voice.of(e.EVERY)
        match goal:
            case f.ForAll(variable, body):
                inner = [body.variable] if isinstance(body, f.Exists) else []
                some = {each.name: f"{e.SOME} {self._noun(each)}" for each in inner}
                return {variable.name: f"{every} {self._noun(variable)}", **some}
            case f.Exists(variable):
                return {variable.name: f"{e.AT_LEAST_ONE} {self._noun(variable)}"}
            case f.Exactly(count, variable):
                noun = self._noun(variable) if count == 1 else e.plural(self._noun(variable))
                return {variable.name: f"{voice.of(e.EXACTLY)} {e.NUMBERS.get(count, count)} {noun}"}
            case f.ForPairs(first, second):
                noun = self._noun(second)
                own = voice.of(e.OWN).format(a="an" if noun[:1] in "aeiou" else "a", noun=noun)
                return {first.name: f"{every} {self._noun(first)}", second.name: own}
            case _:
                return {}

    def _noun(self, variable: f.Variable) -> str:
        return self.nouns[variable.category or ""]

    def _text(self, atom: f.Atom, values: Mapping[str, str], voice: e.Voice, **form: bool) -> str:
        sentence = voice.of(self.sentences(atom.predicate))
        return self._filled(e.turned(sentence, **form), atom, values)

    def _filled(self, sentence: str, atom: f.Atom, values: Mapping[str, str]) -> str:
        words = [values[t.name] if isinstance(t, f.Variable) else self.name(t.name) for t in atom.arguments]
        return _with_words(sentence, words)


def _plain(goal: f.Formula) -> tuple[f.Atom, bool] | None:
    """Return the atom of a goal and whether it is negated; None for goals over time, choices and counts."""
    match goal:
        case (
            f.Not(f.Atom() as atom)
            | f.ForAll(_, f.Not(f.Atom() as atom))
            | f.Exists(_, f.Not(f.Atom() as atom))
        ):
            return atom, True
        case (
            (f.Atom() as atom)
            | f.ForAll(_, f.Atom() as atom)
            | f.Exists(_, f.Atom() as atom)
            | f.ForAll(_, f.Exists(_, f.Atom() as atom))
            | f.ForPairs(_, _, f.Atom() as atom)
        ):
            return atom, False
    return None


def _with_words(sentence: str, words: Sequence[str]) -> str:
    return sentence.format(**dict(zip(parameter_names(len(words)), words, strict=True)))


def _joined(clauses: Sequence[str]) -> str:
    return " and ".join(clauses) if len(clauses) < 3 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"


class _Reader:
    """Reads instructions about one scene back into goals."""

    def __init__(self, words: Words) -> None:
        self._words = words
        self._objects = {words.name(thing.name): thing.name for thing in words.scene.objects}
        self._categories = {noun: category for category, noun in words.nouns.items()}
        self._plurals = {e.plural(noun): category for category, noun in words.nouns.items()}
        self._counts = {word: number for number, word in e.NUMBERS.items()}

    def goals(self, instruction: str) -> tuple[f.Formula, ...]:
        """Return the goals of an instruction.

        Raises:
            InputError: the text is not an instruction, or has several meanings.
        """
        opening = next((o for o in (*e.OPENINGS, *e.REQUESTS) if instruction.startswith(f"{o} ")), None)
        if opening is None or not instruction.endswith("."):
            raise InputError(
                "an instruction: expected a known opening, such as those of prompts, and a full stop"
            )
        text = instruction[len(opening) + 1 : -1]
        *clauses, last = text.split(", ") if ", and " in text else text.split(" and ")
        read = self._request if opening in e.REQUESTS else self._statement
        return tuple(map(read, (*clauses, last.removeprefix("and "))))

    def _request(self, text: str) -> f.Formula:
        if text.startswith(f"{e.SEE_TO_IT} "):
            return self._statement(text.removeprefix(f"{e.SEE_TO_IT} "))
        english = self._words.english
        meanings = [
            meaning
            for negated, requests in ((False, english.asks), (True, english.denies))
            for predicate, several in requests.items()
            for request in several
            for words in _matched(request, text)
            for meaning in self._meaning(predicate, words, negated=negated, request=True)
        ]
        return _one(meanings, text)

    def _statement(self, text: str) -> f.Formula:
        actions = _ACTIONS.fullmatch(text)
        if actions is not None:
            return f.Or(tuple(map(f.Occurs, actions[1].split(" or "))))
        over_time = next((word for word in (e.WHILE, e.UNTIL, e.AFTER) if f" {word} " in text), None)
        if over_time is not None:
            one, other = text.split(f" {over_time} ")
            return self._over_time(over_time, one, other)
        is_choice = text.startswith("either ")
        return _one(self._either(text.removeprefix("either ")) if is_choice else self._meanings(text), text)

    def _over_time(self, word: str, one: str, other: str) -> f.Formula:
        """Return the meaning of two sentences joined by a word."""
        if word == e.WHILE:
            return f.Always(
                f.Not(f.And((_one(self._meanings(one, never=True), one), self._statement(other))))
            )
        if word == e.AFTER:
            return f.Then((self._statement(other), self._statement(one)))
        taken = _TAKEN.fullmatch(other)
        if taken is None:
            return f.Until(self._statement(one), self._statement(other))
        names = [self._objects[name] for name in taken[2].split(" with ") if name in self._objects]
        return f.Until(self._statement(one), f.Occurs(taken[1], tuple(map(f.Constant, names))))

    def _either(self, text: str) -> Iterator[f.Formula]:
        for place in re.finditer(" or ", text):
            for first in self._meanings(text[: place.start()]):
                yield from (f.Or((first, second)) for second in self._meanings(text[place.end() :]))

    def _meanings(self, text: str, *, never: bool = False) -> Iterator[f.Formula]:
        """Yield all meanings of a sentence; with `never`, of a sentence that says that a fact never holds."""
        forms = ((False, False),) if never else ((False, False), (True, False), (False, True))
        for predicate in self._words.arities:
            for sentence in self._words.sentences(predicate):
                for negated, several in forms:
                    form = e.turned(sentence, negated=negated, several=several, never=never)
                    for words in _matched(form, text):
                        yield from self._meaning(predicate, words, negated=negated, several=several)

    def _meaning(
        self,
        predicate: str,
        words: Sequence[str],
        *,
        negated: bool,
        several: bool = False,
        request: bool = False,
    ) -> Iterator[f.Formula]:
        """Yield the meaning of a sentence that states a predicate of objects in words, or requests it."""
        named = [self._objects.get(word) for word in words]
        rest = tuple([f.Constant(name) for name in named[1:] if name is not None])
        is_ground = None not in named[1:]

        def atom(*terms: f.Term) -> f.Formula:
            return f.Not(f.Atom(predicate, terms)) if negated else f.Atom(predicate, terms)

        if not named or named[0] is not None:
            if is_ground and not several:
                yield atom(*[f.Constant(name) for name in named if name is not None])
            return
        found = _QUANTIFIED.fullmatch(words[0])
        if found is None:
            return
        number = found["number"] or ""
        count = self._counts.get(number) or (int(number) if _NUMBER.fullmatch(number) else None)
        category = (self._plurals if several else self._categories).get(found["noun"])
        if category is None or several != (count not in (None, 1)):
            return
        x = f.Variable("x", category)
        if is_ground:
            yield from _quantified(found, count, x, atom(_X, *rest), negated=negated, request=request)
        elif found["every"] and not negated:
            inner = _INNER.fullmatch(words[1])
            target = None if inner is None else self._categories.get(next(filter(None, inner.groups())))
            if inner is not None and target is not None:
                y = f.Variable("y", target)
                yield f.ForAll(x, f.Exists(y, atom(_X, _Y))) if inner[1] else f.ForPairs(x, y, atom(_X, _Y))


def _quantified(
    found: re.Match[str], count: int | None, x: f.Variable, body: f.Formula, *, negated: bool, request: bool
) -> Iterator[f.Formula]:
    """Yield the meaning of a sentence with a quantifier; "every ... is not" has no meaning."""
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
    return re.compile(re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+)", re.escape(sentence)))


def _matched(sentence: str, text: str) -> Iterator[Sequence[str]]:
    """Yield the words for the objects of a sentence, if a text is that sentence."""
    found = _pattern(sentence).fullmatch(text)
    if found is not None:
        named = found.groupdict()
        yield [named[name] for name in parameter_names(len(named))]


def _one(meanings: Iterable[f.Formula], text: str) -> f.Formula:
    found = list(meanings)
    if len(found) != 1:
        raise InputError(f"expected a sentence with one meaning, found {len(found)} of {text!r}")
    return found[0]
