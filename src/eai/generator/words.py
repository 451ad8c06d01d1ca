"""Goals in English: sentences that say exactly the goal; `eai.generator.objections` gets it back."""

from __future__ import annotations

import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import eai.logic.formula as f
from eai.abilities.protocol import Ability
from eai.benchmark.benchmark import Benchmark
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
    USUAL,
    WHILE,
    English,
    Voice,
    plural,
    sentences_of,
    turned,
)
from eai.errors import InputError
from eai.world.state import Fact, Scene, State


@dataclass(frozen=True)
class Words:
    """How instructions about one scene name things.

    Attributes:
        arities: the predicates that goals are made of, and how many objects each is about.
        scene: the scene.
        english: what predicates and things are called; by default their names.
        seen: what holds at the start, by which things of one kind may be told apart.
    """

    arities: Mapping[str, int]
    scene: Scene
    english: English
    seen: Sequence[Fact] = ()

    @staticmethod
    def of(benchmark: Benchmark, initial: State, *, by_place: bool = False) -> Words:
        """The words of a benchmark for a scene; things may be told by where they are, instead of by name."""
        arity, scene = benchmark.domain.vocabulary.arity, initial.scene
        wording = benchmark.wording(Ability.ACTION_SEQUENCING)
        arities = {name: arity(name) or 0 for name in wording.predicates}
        everything = range(len(scene.objects)) if by_place else ()
        seen = [fact for each in wording.listings for fact in each.facts(initial, everything)]
        return Words(arities, scene, benchmark.english, seen)

    def sentences(self, predicate: str) -> Sequence[str]:
        """What says that a predicate holds, in the singular: ``{x} is on top of {y}``."""
        return sentences_of(predicate, self.arities[predicate], self.english)

    @cached_property
    def nouns(self) -> Mapping[str, str]:
        """Return the noun of each category of the scene; by its name where two would be called the same."""
        found: dict[str, str] = {}
        for thing in self.scene.objects:
            made = re.sub(r"\.n\.\d+$", "", thing.category).replace("_", " ")
            noun = self.english.nouns.get(thing.category, made)
            taken = any(n == noun and c != thing.category for c, n in found.items())
            found.setdefault(thing.category, thing.category if taken else noun)
        return found

    def name(self, name: str) -> str:
        """Return the name of an object: ``the lamp`` if there is no other, else by its place or its name."""
        index = self.scene.index[name]
        return f"the {self._noun_of(index)}" if self._is_alone(index) else self._by_place.get(index, name)

    def is_told(self, name: str) -> bool:
        """Whether an object can be told from others without its name."""
        index = self.scene.index[name]
        return self._is_alone(index) or index in self._by_place

    @cached_property
    def _by_place(self) -> Mapping[int, str]:
        """What tells things from others of their kind at the start.

        To what, of which there is one, they alone are in a relation, or what is so of them alone.
        """
        told: dict[tuple[str, str, tuple[int, ...]], list[int]] = {}
        for fact in sorted(self.seen, key=lambda fact: -len(fact.arguments)):
            thing, *places = fact.arguments
            if all(map(self._is_alone, places)):
                category = self.scene.objects[thing].category
                told.setdefault((fact.predicate, category, tuple(places)), []).append(thing)
        found: dict[int, str] = {}
        for (predicate, _, there), (thing, *others) in told.items():
            if not others and not self._is_alone(thing):
                words = [f"the {self._noun_of(thing)} that", *(f"the {self._noun_of(i)}" for i in there)]
                sentence = self.sentences(predicate)[0]
                sentence = sentence if there else f"{sentence} now"  # it may not be so in the end
                found.setdefault(thing, sentence.format(**dict(zip("xy", words, strict=False))))
        return found

    def _noun_of(self, index: int) -> str:
        return self.nouns[self.scene.objects[index].category]

    def _is_alone(self, index: int) -> bool:
        return self.scene.category(self.scene.objects[index].category).bit_count() == 1

    def instruction(self, goals: Sequence[f.Formula], rng: random.Random) -> str:
        """A sentence that says all goals.

        Raises:
            InputError: a goal has a shape for which there is no sentence.
        """
        voice = Voice.drawn(rng)
        opening = rng.choice(REQUESTS if voice.requests else OPENINGS)
        return f"{opening} {_joined([self.clause(goal, voice) for goal in goals])}."

    def clause(self, goal: f.Formula, voice: Voice = USUAL) -> str:
        """A part of an instruction that says a goal."""
        if not voice.requests:
            return self._statement(goal, voice)
        return self._request(goal, voice) or f"{SEE_TO_IT} {self._statement(goal, voice)}"

    def _request(self, goal: f.Formula, voice: Voice) -> str | None:
        """What to do to reach a goal, where that can be said without saying less."""
        match goal:
            case (
                f.Not(f.Atom() as atom)
                | f.ForAll(_, f.Not(f.Atom() as atom))
                | f.Exists(_, f.Not(f.Atom() as atom))
            ):
                requests = self.english.denies
            case (
                (f.Atom() as atom)
                | f.ForAll(_, f.Atom() as atom)
                | f.Exists(_, f.Atom() as atom)
                | f.ForAll(_, f.Exists(_, f.Atom() as atom))
                | f.ForPairs(_, _, f.Atom() as atom)
            ):
                requests = self.english.asks
            case _:
                return None
        first = next(iter(atom.arguments), None)
        if isinstance(first, f.Constant) and self.scene.index[first.name] == self.scene.agent:
            return None  # nobody puts an agent on a couch
        several = requests.get(atom.predicate)
        return None if several is None else self._filled(voice.of(several), atom, self._ranges(goal, voice))

    def _statement(self, goal: f.Formula, voice: Voice) -> str:
        """What is to be so, without a full stop."""
        match goal:
            case f.Or(parts) if all(isinstance(part, f.Occurs) for part in parts):
                names = [part.action for part in parts if isinstance(part, f.Occurs)]
                return f"the action {' or '.join(names)} has been taken"
            case f.Or((first, second)):
                return f"either {self._statement(first, voice)} or {self._statement(second, voice)}"
            case f.ForAll(variable, f.Not(f.Atom() as atom)):
                return self._said(atom, {variable.name: f"{NO} {self._noun(variable)}"}, voice)
            case f.Exists(_, f.Not(f.Atom() as atom)) | f.Not(f.Atom() as atom):
                return self._said(atom, self._ranges(goal, voice), voice, negated=True)
            case f.Exactly(count, _, f.Atom() as atom):
                return self._said(atom, self._ranges(goal, voice), voice, several=count != 1)
            case (
                (f.Atom() as atom)
                | f.ForAll(_, f.Atom() as atom)
                | f.Exists(_, f.Atom() as atom)
                | f.ForAll(_, f.Exists(_, f.Atom() as atom))
                | f.ForPairs(_, _, f.Atom() as atom)
            ):
                return self._said(atom, self._ranges(goal, voice), voice)
        return self._clause_over_time(goal, voice)

    def _clause_over_time(self, goal: f.Formula, voice: Voice) -> str:
        """A sentence that says a goal about the whole course."""
        match goal:
            case f.Always(f.Not(f.And((f.Atom() as one, other)))):
                return f"{self._said(one, {}, voice, never=True)} {WHILE} {self._statement(other, voice)}"
            case f.Until(f.Not(f.Atom() as then), f.Occurs(action, terms)):
                named = " with ".join([self.name(term.name) for term in terms])
                taken = f"the action {action} has been taken on {named}"
                return f"{self._said(then, {}, voice, negated=True)} {UNTIL} {taken}"
            case f.Until(f.Not(f.Atom() as then), first):
                return f"{self._said(then, {}, voice, negated=True)} {UNTIL} {self._statement(first, voice)}"
            case f.Then((first, then)):
                return f"{self._statement(then, voice)} {AFTER} {self._statement(first, voice)}"
        raise InputError(f"there is no sentence for {type(goal).__name__}")

    def _ranges(self, goal: f.Formula, voice: Voice) -> dict[str, str]:
        """What stands for each variable of a goal in a sentence."""
        every = voice.of(EVERY)
        match goal:
            case f.ForAll(variable, f.Exists(inner)):
                return {
                    variable.name: f"{every} {self._noun(variable)}",
                    inner.name: f"{SOME} {self._noun(inner)}",
                }
            case f.ForAll(variable):
                return {variable.name: f"{every} {self._noun(variable)}"}
            case f.Exists(variable):
                return {variable.name: f"{AT_LEAST_ONE} {self._noun(variable)}"}
            case f.Exactly(count, variable):
                noun = self._noun(variable) if count == 1 else plural(self._noun(variable))
                return {variable.name: f"{voice.of(EXACTLY)} {NUMBERS.get(count, count)} {noun}"}
            case f.ForPairs(first, second):
                noun = self._noun(second)
                own = voice.of(OWN).format(a="an" if noun[:1] in "aeiou" else "a", noun=noun)
                return {first.name: f"{every} {self._noun(first)}", second.name: own}
            case _:
                return {}

    def _noun(self, variable: f.Variable) -> str:
        return self.nouns[variable.category or ""]

    def _said(
        self,
        atom: f.Atom,
        values: Mapping[str, str],
        voice: Voice,
        *,
        negated: bool = False,
        several: bool = False,
        never: bool = False,
    ) -> str:
        """The sentence of an atom, its variables replaced by what they range over."""
        sentence = voice.of(self.sentences(atom.predicate))
        return self._filled(turned(sentence, negated=negated, several=several, never=never), atom, values)

    def _filled(self, sentence: str, atom: f.Atom, values: Mapping[str, str]) -> str:
        said = [values[t.name] if isinstance(t, f.Variable) else self.name(t.name) for t in atom.arguments]
        return sentence.format(**dict(zip("xy", said, strict=False)))


def _joined(clauses: Sequence[str]) -> str:
    return " and ".join(clauses) if len(clauses) < 3 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"
