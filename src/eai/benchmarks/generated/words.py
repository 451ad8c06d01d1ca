"""Goals in English: sentences that say exactly the goal; `eai.benchmarks.generated.reader` gets it back."""

from __future__ import annotations

import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import eai.logic.formula as f
from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.errors import InputError
from eai.world.state import Fact, Scene, State

OPENINGS = (
    "Make sure that",
    "See to it that",
    "Please arrange things so that in the end",
    "When you are done, it should be the case that",
)
"""How an instruction begins; each says the same."""

EVERY, NO, SOME, AT_LEAST_ONE, EXACTLY, OF_ITS_OWN = (
    "every",
    "no",
    "some",
    "at least one",
    "exactly",
    "of its own",
)

NEVER, WHILE, UNTIL, AFTER = "never", "while", "until", "some time after"
"""What joins two sentences of a goal over time."""

NUMBERS = {1: "one", 2: "two", 3: "three", 4: "four"}
"""Numbers that are written as words."""

_PLURAL = {"is": "are", "has": "have", "holds": "hold", "faces": "face"}


@dataclass(frozen=True)
class Words:
    """How instructions about one scene name things.

    Attributes:
        arities: the predicates that goals are made of, and how many objects each is about.
        scene: the scene.
        phrases: how to say that a predicate holds, by its name: a sentence in the singular whose second word
            is a verb of which the plural is known, as in ``{x} is on top of {y}``; if none, made of the name.
        seen: what holds at the start, by which things of one kind may be told apart.
    """

    arities: Mapping[str, int]
    scene: Scene
    phrases: Mapping[str, str]
    seen: Sequence[Fact] = ()

    @staticmethod
    def of(benchmark: Benchmark, initial: State, *, by_place: bool = False) -> Words:
        """The words of a benchmark for a scene; things may be told by where they are, instead of by name."""
        arity, scene = benchmark.domain.vocabulary.arity, initial.scene
        wording = benchmark.wording(Ability.ACTION_SEQUENCING)
        arities = {name: arity(name) or 0 for name in wording.predicates}
        everything = range(len(scene.objects)) if by_place else ()
        seen = [fact for each in wording.listings for fact in each.facts(initial, everything)]
        return Words(arities, scene, benchmark.phrases, seen)

    def phrase(
        self, predicate: str, *, negated: bool = False, several: bool = False, never: bool = False
    ) -> str:
        """The sentence of a predicate, denied (once or for ever) or in the plural."""
        first, verb, *rest = phrase_of(predicate, self.arities[predicate], self.phrases).split(" ")
        is_short = verb in ("is", "has")
        if never:
            verb = f"{verb} {NEVER}" if is_short else f"{NEVER} {verb}"
        if negated:
            verb = f"{verb} not" if is_short else f"does not {verb.removesuffix('s')}"
        return " ".join([first, _PLURAL.get(verb, verb) if several else verb, *rest])

    @cached_property
    def nouns(self) -> Mapping[str, str]:
        """What each category of the scene is called; by its name where two would be called the same."""
        found: dict[str, str] = {}
        for thing in self.scene.objects:
            noun = re.sub(r"\.n\.\d+$", "", thing.category).replace("_", " ")
            taken = any(n == noun and c != thing.category for c, n in found.items())
            found.setdefault(thing.category, thing.category if taken else noun)
        return found

    def name(self, name: str) -> str:
        """What an object is called: ``the lamp`` if there is no other, else by its place or its name."""
        index = self.scene.index[name]
        return f"the {self._noun_of(index)}" if self._is_alone(index) else self._by_place.get(index, name)

    @cached_property
    def _by_place(self) -> Mapping[int, str]:
        """What tells things from others of their kind at the start: to what they alone are in a relation."""
        told: dict[tuple[str, str, int], list[int]] = {}
        for fact in self.seen:
            if len(fact.arguments) == 2 and self._is_alone(fact.arguments[1]):
                thing, place = fact.arguments
                told.setdefault((fact.predicate, self.scene.objects[thing].category, place), []).append(thing)
        found: dict[int, str] = {}
        for (predicate, _, place), things in told.items():
            if len(things) == 1 and not self._is_alone(things[0]):
                noun, there = (self._noun_of(index) for index in (things[0], place))
                found.setdefault(
                    things[0], self.phrase(predicate).format(x=f"the {noun} that", y=f"the {there}")
                )
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
        clauses = [self.clause(goal) for goal in goals]
        return f"{rng.choice(OPENINGS)} {_joined(clauses)}."

    def clause(self, goal: f.Formula) -> str:
        """A sentence that says a goal, without its full stop."""
        match goal:
            case f.Or(parts) if all(isinstance(part, f.Occurs) for part in parts):
                names = [part.action for part in parts if isinstance(part, f.Occurs)]
                return f"the action {' or '.join(names)} has been taken"
            case f.Or((first, second)):
                return f"either {self.clause(first)} or {self.clause(second)}"
            case f.ForAll(variable, f.Not(f.Atom() as atom)):
                return self._said(atom, {variable.name: f"{NO} {self._noun(variable)}"})
            case f.Exists(variable, f.Not(f.Atom() as atom)):
                return self._said(atom, self._ranges(goal), negated=True)
            case f.Not(f.Atom() as atom):
                return self._said(atom, {}, negated=True)
            case f.ForAll(_, f.Exists(_, f.Atom() as atom)) | f.Exactly(_, _, f.Atom() as atom):
                several = isinstance(goal, f.Exactly) and goal.count != 1
                return self._said(atom, self._ranges(goal), several=several)
            case (
                f.ForAll(_, f.Atom() as atom)
                | f.Exists(_, f.Atom() as atom)
                | f.ForPairs(_, _, f.Atom() as atom)
            ):
                return self._said(atom, self._ranges(goal))
            case f.Atom():
                return self._said(goal, {})
        return self._clause_over_time(goal)

    def _clause_over_time(self, goal: f.Formula) -> str:
        """A sentence that says a goal about the whole course."""
        match goal:
            case f.Always(f.Not(f.And((f.Atom() as one, other)))):
                return f"{self._said(one, {}, never=True)} {WHILE} {self.clause(other)}"
            case f.Until(f.Not(f.Atom() as then), f.Occurs(action, terms)):
                named = " with ".join([self.name(term.name) for term in terms])
                taken = f"the action {action} has been taken on {named}"
                return f"{self._said(then, {}, negated=True)} {UNTIL} {taken}"
            case f.Until(f.Not(f.Atom() as then), first):
                return f"{self._said(then, {}, negated=True)} {UNTIL} {self.clause(first)}"
            case f.Then((first, then)):
                return f"{self.clause(then)} {AFTER} {self.clause(first)}"
        raise InputError(f"there is no sentence for {type(goal).__name__}")

    def _ranges(self, goal: f.Formula) -> dict[str, str]:
        """What stands for each variable of a goal in a sentence."""
        match goal:
            case f.ForAll(variable, body):
                inner = (
                    {body.variable.name: f"{SOME} {self._noun(body.variable)}"}
                    if isinstance(body, f.Exists)
                    else {}
                )
                return {variable.name: f"{EVERY} {self._noun(variable)}", **inner}
            case f.Exists(variable):
                return {variable.name: f"{AT_LEAST_ONE} {self._noun(variable)}"}
            case f.Exactly(count, variable):
                noun = self._noun(variable) if count == 1 else plural(self._noun(variable))
                return {variable.name: f"{EXACTLY} {NUMBERS.get(count, count)} {noun}"}
            case f.ForPairs(first, second):
                noun = self._noun(second)
                own = f"{'an' if noun[:1] in 'aeiou' else 'a'} {noun} {OF_ITS_OWN}"
                return {first.name: f"{EVERY} {self._noun(first)}", second.name: own}
            case _:
                return {}

    def _noun(self, variable: f.Variable) -> str:
        return self.nouns[variable.category or ""]

    def _said(
        self,
        atom: f.Atom,
        values: Mapping[str, str],
        *,
        negated: bool = False,
        several: bool = False,
        never: bool = False,
    ) -> str:
        """The sentence of an atom, its variables replaced by what they range over."""
        said = [values[t.name] if isinstance(t, f.Variable) else self.name(t.name) for t in atom.arguments]
        phrase = self.phrase(atom.predicate, negated=negated, several=several, never=never)
        return phrase.format(**dict(zip("xy", said, strict=False)))


def phrase_of(predicate: str, arity: int, phrases: Mapping[str, str]) -> str:
    """The sentence of a predicate in the singular, such as ``{x} is on top of {y}``."""
    given = phrases.get(predicate)
    if given is not None:
        return given
    name = re.sub("[_-]", " ", predicate).lower().removeprefix("is ")
    verb = name if name in _PLURAL else f"is {name}"
    return f"{{x}} {verb} {{y}}" if arity == 2 else f"{{x}} {verb}"


def plural(noun: str) -> str:
    """The plural of a noun, as regular English has it."""
    if re.search(r"(?:s|x|z|ch|sh)$", noun):
        return f"{noun}es"
    if re.search(r"[^aeiou]y$", noun):
        return f"{noun[:-1]}ies"
    if noun.endswith(("knife", "shelf", "loaf", "leaf")):
        return f"{noun.removesuffix('e').removesuffix('f')}ves"
    return f"{noun}s"


def _joined(clauses: Sequence[str]) -> str:
    return " and ".join(clauses) if len(clauses) < 3 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"
