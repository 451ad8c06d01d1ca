"""Write goals as English instructions, and read instructions back into goals.

An instruction is exact if reading it gives exactly the goals of the task.
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
from eai.world.vocabulary import make_parameter_names

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
class InstructionWriter:
    """Writes instructions for tasks in one scene, with words for its objects and predicates.

    Attributes:
        arities: number of arguments of each predicate of goals.
        scene: the scene.
        english: English words for predicates and categories. A predicate or category without words keeps its
            name.
        initial_facts: initial facts by which objects of one category may be distinguished.
    """

    arities: Mapping[str, int]
    scene: Scene
    english: e.EnglishWords
    initial_facts: Sequence[Fact] = ()

    @staticmethod
    def make_writer_for_benchmark(
        benchmark: Benchmark, initial: State, *, distinguishes_objects_by_place: bool = False
    ) -> InstructionWriter:
        """Return a writer of instructions for tasks in a benchmark's scene.

        If `distinguishes_objects_by_place` is true, instructions distinguish objects of one category by place
        or state, not by name.
        """
        arity, scene = benchmark.domain.vocabulary.find_arity, initial.scene
        wording = benchmark.wording(Ability.ACTION_SEQUENCING)
        arities = {name: arity(name) or 0 for name in wording.predicates}
        everything = range(len(scene.objects)) if distinguishes_objects_by_place else ()
        seen = [
            fact
            for listing in wording.fact_listers_of_goal_predicates
            for fact in listing.list_facts(initial, everything)
        ]
        return InstructionWriter(arities, scene, benchmark.notation.english, seen)

    def get_sentences(self, predicate: str) -> Sequence[str]:
        """Return patterns of sentences that state a fact of a predicate, such as ``{x} is on top of {y}``.

        Their verbs are in the singular.
        """
        return e.make_predicate_sentences(predicate, self.arities[predicate], self.english)

    @cached_property
    def noun_by_category(self) -> Mapping[str, str]:
        """Mapping from category to noun.

        If another category has the noun already, the category itself is used.
        """
        nouns: dict[str, str] = {}
        for thing in self.scene.objects:
            made = " ".join(re.sub(r"\.n\.\d+$", "", thing.category).replace("_", " ").split())
            noun = self.english.nouns.get(thing.category, made)
            taken = any(n == noun and c != thing.category for c, n in nouns.items())
            nouns.setdefault(thing.category, thing.category if taken else noun)
        return nouns

    def get_words_for_object(self, object_name: str) -> str:
        """Return words for an object: ``the lamp`` for the only lamp, a description by place, or its name."""
        index = self.scene.index[object_name]
        if self._is_only_one_of_category(index):
            return self._name_by_category(index)
        return self._description_by_object.get(index, object_name)

    def can_object_be_described_without_name(self, object_name: str) -> bool:
        """Whether words other than its name can describe an object."""
        index = self.scene.index[object_name]
        return self._is_only_one_of_category(index) or index in self._description_by_object

    @cached_property
    def distinguishing_fact_by_object(self) -> Mapping[int, Fact]:
        """Mapping from an object to the initial fact by which it differs from others of its category.

        The fact states a state that no other object of the category has, or a relation to the only object of
        another category.
        """
        described: dict[tuple[str, str, tuple[int, ...]], list[int]] = {}
        about = [fact for fact in self.initial_facts if fact.arguments]
        for fact in sorted(about, key=lambda fact: -len(fact.arguments)):
            thing, *places = fact.arguments
            if all(map(self._is_only_one_of_category, places)):
                category = self.scene.objects[thing].category
                described.setdefault((fact.predicate, category, tuple(places)), []).append(thing)
        facts: dict[int, Fact] = {}
        for (predicate, _, there), (thing, *others) in described.items():
            if not others and not self._is_only_one_of_category(thing):
                facts.setdefault(thing, Fact(predicate, (thing, *there)))
        return facts

    @cached_property
    def _description_by_object(self) -> Mapping[int, str]:
        return {
            thing: self._describe_object_by_fact(*fact)
            for thing, fact in self.distinguishing_fact_by_object.items()
        }

    def _describe_object_by_fact(self, predicate: str, arguments: Sequence[int]) -> str:
        thing, *there = arguments
        sentence = self.get_sentences(predicate)[0]
        sentence = sentence if there else f"{sentence} now"  # e.g. "the lamp that is off now"
        return _fill_sentence(
            sentence, [f"the {self._get_object_noun(thing)} that", *map(self._name_by_category, there)]
        )

    def _name_by_category(self, index: int) -> str:
        return f"the {self._get_object_noun(index)}"

    def _get_object_noun(self, index: int) -> str:
        return self.noun_by_category[self.scene.objects[index].category]

    def _is_only_one_of_category(self, index: int) -> bool:
        return self.scene.get_category_mask(self.scene.objects[index].category).bit_count() == 1

    def make_instruction(self, goals: Sequence[f.Formula], rng: random.Random) -> str:
        """Return an instruction that states all goals.

        Raises:
            InputError: no sentence form can state a goal.
        """
        style = e.PhraseStyle.draw_random_style(rng)
        opening = rng.choice(e.REQUESTS if style.requests else e.OPENINGS)
        return f"{opening} {_join_clauses([self.make_clause(goal, style) for goal in goals])}."

    def does_instruction_state_exactly_goals(self, instruction: str, goals: Sequence[f.Formula]) -> bool:
        """Whether the goals read from an instruction are exactly these goals."""
        try:
            return _InstructionReader(self).read_goals(instruction) == tuple(goals)
        except InputError:
            return False

    def make_clause(self, goal: f.Formula, style: e.PhraseStyle = e.USUAL_STYLE) -> str:
        """Return a clause that states a goal as part of an instruction."""
        if not style.requests:
            return self._make_statement(goal, style)
        return self._make_request(goal, style) or f"{e.SEE_TO_IT} {self._make_statement(goal, style)}"

    def _make_request(self, goal: f.Formula, style: e.PhraseStyle) -> str | None:
        """Return a request that states a goal, such as "put ...", or None if no request can state it."""
        plain = _find_single_atom_and_whether_negated(goal)
        if plain is None:
            return None
        atom, negated = plain
        first = next(iter(atom.arguments), None)
        if isinstance(first, f.Constant) and self.scene.index[first.name] == self.scene.agent:
            return None  # a request to put the agent on a couch makes no sense
        several = (self.english.denies if negated else self.english.asks).get(atom.predicate)
        if several is None:
            return None
        return self._fill_in_objects(style.choose(several), atom, self._name_variables(goal, style))

    def _make_statement(self, goal: f.Formula, style: e.PhraseStyle) -> str:
        """Return a statement, without a full stop, that states a goal."""
        match goal:
            case f.Or(parts) if all(isinstance(part, f.Occurs) for part in parts):
                names = [part.action for part in parts if isinstance(part, f.Occurs)]
                return f"the action {' or '.join(names)} has been taken"
            case f.Or((first, second)):
                return f"either {self._make_statement(first, style)} or {self._make_statement(second, style)}"
            case f.ForAll(variable, f.Not(f.Atom() as atom)):
                return self._make_sentence(
                    atom, {variable.name: f"{e.NO} {self._get_variable_noun(variable)}"}, style
                )
            case f.Exactly(count, _, f.Atom() as atom):
                return self._make_sentence(atom, self._name_variables(goal, style), style, plural=count != 1)
        plain = _find_single_atom_and_whether_negated(goal)
        if plain is None:
            return self._make_statement_of_temporal_goal(goal, style)
        atom, negated = plain
        return self._make_sentence(atom, self._name_variables(goal, style), style, negated=negated)

    def _make_statement_of_temporal_goal(self, goal: f.Formula, style: e.PhraseStyle) -> str:
        match goal:
            case f.Always(f.Not(f.And((f.Atom() as one, other)))):
                never = self._make_sentence(one, {}, style, never=True)
                return f"{never} {e.WHILE} {self._make_statement(other, style)}"
            case f.Until(f.Not(f.Atom() as then), f.Occurs(action, terms)):
                named = " with ".join([self.get_words_for_object(term.name) for term in terms])
                taken = f"the action {action} has been taken on {named}"
                return f"{self._make_sentence(then, {}, style, negated=True)} {e.UNTIL} {taken}"
            case f.Until(f.Not(f.Atom() as then), first):
                denied = self._make_sentence(then, {}, style, negated=True)
                return f"{denied} {e.UNTIL} {self._make_statement(first, style)}"
            case f.Then((first, then)):
                return f"{self._make_statement(then, style)} {e.AFTER} {self._make_statement(first, style)}"
        raise InputError(
            f"no sentence can state a goal of the class {type(goal).__name__}; use another formula"
        )

    def _name_variables(self, goal: f.Formula, style: e.PhraseStyle) -> dict[str, str]:
        """Return a mapping from variables of a goal to words, such as ``every lamp``."""
        every = style.choose(e.EVERY)
        match goal:
            case f.ForAll(variable, body):
                inner = [body.variable] if isinstance(body, f.Exists) else []
                some = {each.name: f"{e.SOME} {self._get_variable_noun(each)}" for each in inner}
                return {variable.name: f"{every} {self._get_variable_noun(variable)}", **some}
            case f.Exists(variable):
                return {variable.name: f"{e.AT_LEAST_ONE} {self._get_variable_noun(variable)}"}
            case f.Exactly(count, variable):
                noun = (
                    self._get_variable_noun(variable)
                    if count == 1
                    else e.pluralize(self._get_variable_noun(variable))
                )
                return {variable.name: f"{style.choose(e.EXACTLY)} {e.NUMBERS.get(count, count)} {noun}"}
            case f.ForPairs(first, second):
                noun = self._get_variable_noun(second)
                own = style.choose(e.OWN).format(a="an" if noun[:1] in "aeiou" else "a", noun=noun)
                return {first.name: f"{every} {self._get_variable_noun(first)}", second.name: own}
            case _:
                return {}

    def _get_variable_noun(self, variable: f.Variable) -> str:
        return self.noun_by_category[variable.category or ""]

    def _make_sentence(
        self, atom: f.Atom, values: Mapping[str, str], style: e.PhraseStyle, **inflection: bool
    ) -> str:
        sentence = style.choose(self.get_sentences(atom.predicate))
        return self._fill_in_objects(e.inflect_sentence(sentence, **inflection), atom, values)

    def _fill_in_objects(self, sentence: str, atom: f.Atom, values: Mapping[str, str]) -> str:
        words = [
            values[t.name] if isinstance(t, f.Variable) else self.get_words_for_object(t.name)
            for t in atom.arguments
        ]
        return _fill_sentence(sentence, words)


def _find_single_atom_and_whether_negated(goal: f.Formula) -> tuple[f.Atom, bool] | None:
    """Return the only atom of a goal and whether the atom is negated; None for goals of other shapes."""
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


def _fill_sentence(sentence: str, words: Sequence[str]) -> str:
    return sentence.format(**dict(zip(make_parameter_names(len(words)), words, strict=True)))


def _join_clauses(clauses: Sequence[str]) -> str:
    return " and ".join(clauses) if len(clauses) < 3 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"


class _InstructionReader:
    """Reads instructions about one scene back into goals."""

    def __init__(self, words: InstructionWriter) -> None:
        self._words = words
        self._objects = {words.get_words_for_object(thing.name): thing.name for thing in words.scene.objects}
        self._categories = {noun: category for category, noun in words.noun_by_category.items()}
        self._plurals = {e.pluralize(noun): category for category, noun in words.noun_by_category.items()}
        self._counts = {word: number for number, word in e.NUMBERS.items()}

    def read_goals(self, instruction: str) -> tuple[f.Formula, ...]:
        """Return the goals of an instruction.

        Raises:
            InputError: the text is not an instruction, or has several meanings.
        """
        opening = next((o for o in (*e.OPENINGS, *e.REQUESTS) if instruction.startswith(f"{o} ")), None)
        if opening is None or not instruction.endswith("."):
            raise InputError(
                f"expected an instruction that begins with one of {(*e.OPENINGS, *e.REQUESTS)} and "
                f"ends with a full stop, found {instruction!r}"
            )
        text = instruction[len(opening) + 1 : -1]
        *clauses, last = text.split(", ") if ", and " in text else text.split(" and ")
        read = self._read_request if opening in e.REQUESTS else self._read_statement
        return tuple(map(read, (*clauses, last.removeprefix("and "))))

    def _read_request(self, text: str) -> f.Formula:
        if text.startswith(f"{e.SEE_TO_IT} "):
            return self._read_statement(text.removeprefix(f"{e.SEE_TO_IT} "))
        english = self._words.english
        meanings = [
            meaning
            for negated, requests in ((False, english.asks), (True, english.denies))
            for predicate, several in requests.items()
            for request in several
            for words in _find_arguments_by_sentence_pattern(request, text)
            for meaning in self._interpret_sentence(predicate, words, negated=negated, is_request=True)
        ]
        return _require_one_meaning(meanings, text)

    def _read_statement(self, text: str) -> f.Formula:
        actions = _ACTIONS.fullmatch(text)
        if actions is not None:
            return f.Or(tuple(map(f.Occurs, actions[1].split(" or "))))
        over_time = next((word for word in (e.WHILE, e.UNTIL, e.AFTER) if f" {word} " in text), None)
        if over_time is not None:
            clauses = text.split(f" {over_time} ")
            if len(clauses) != 2:
                raise InputError(f"expected the word {over_time!r} only once in {text!r}")
            return self._read_goal_with_time_word(over_time, *clauses)
        is_choice = text.startswith("either ")
        return _require_one_meaning(
            self._yield_readings_of_disjunction(text.removeprefix("either "))
            if is_choice
            else self._parse_goals(text),
            text,
        )

    def _read_goal_with_time_word(self, time_word: str, first_clause: str, second_clause: str) -> f.Formula:
        """Return the temporal goal that two sentences state if a word such as "before" joins them."""
        if time_word == e.WHILE:
            return f.Always(
                f.Not(
                    f.And(
                        (
                            _require_one_meaning(self._parse_goals(first_clause, forbids=True), first_clause),
                            self._read_statement(second_clause),
                        )
                    )
                )
            )
        if time_word == e.AFTER:
            return f.Then((self._read_statement(second_clause), self._read_statement(first_clause)))
        taken = _TAKEN.fullmatch(second_clause)
        if taken is None:
            return f.Until(self._read_statement(first_clause), self._read_statement(second_clause))
        names = [self._objects[name] for name in taken[2].split(" with ") if name in self._objects]
        return f.Until(self._read_statement(first_clause), f.Occurs(taken[1], tuple(map(f.Constant, names))))

    def _yield_readings_of_disjunction(self, text: str) -> Iterator[f.Formula]:
        for place in re.finditer(" or ", text):
            for first in self._parse_goals(text[: place.start()]):
                yield from (f.Or((first, second)) for second in self._parse_goals(text[place.end() :]))

    def _parse_goals(self, text: str, *, forbids: bool = False) -> Iterator[f.Formula]:
        """Yield all goals that a sentence may mean.

        If `forbids` is true, the sentence forbids a fact.
        """
        forms = ((False, False),) if forbids else ((False, False), (True, False), (False, True))
        for predicate in self._words.arities:
            for sentence in self._words.get_sentences(predicate):
                for negated, several in forms:
                    form = e.inflect_sentence(sentence, negated=negated, plural=several, never=forbids)
                    for words in _find_arguments_by_sentence_pattern(form, text):
                        yield from self._interpret_sentence(
                            predicate, words, negated=negated, is_plural=several
                        )

    def _interpret_sentence(
        self,
        predicate: str,
        argument_phrases: Sequence[str],
        *,
        negated: bool,
        is_plural: bool = False,
        is_request: bool = False,
    ) -> Iterator[f.Formula]:
        """Yield the goal that a sentence, a statement or request, expresses.

        The sentence matches a sentence pattern of the predicate. `argument_phrases` are its words for the
        arguments, such as ``every lamp``.
        """
        named = [self._objects.get(word) for word in argument_phrases]
        rest = tuple([f.Constant(name) for name in named[1:] if name is not None])
        is_ground = None not in named[1:]

        def make_literal(*terms: f.Term) -> f.Formula:
            return f.Not(f.Atom(predicate, terms)) if negated else f.Atom(predicate, terms)

        if not named or named[0] is not None:
            if is_ground and not is_plural:
                yield make_literal(*[f.Constant(name) for name in named if name is not None])
            return
        quantifier = _QUANTIFIED.fullmatch(argument_phrases[0])
        if quantifier is None:
            return
        number = quantifier["number"] or ""
        count = self._counts.get(number) or (int(number) if _NUMBER.fullmatch(number) else None)
        category = (self._plurals if is_plural else self._categories).get(quantifier["noun"])
        if category is None or is_plural != (count not in (None, 1)):
            return
        x = f.Variable("x", category)
        if is_ground:
            yield from _interpret_quantified(
                quantifier, count, x, make_literal(_X, *rest), negated=negated, is_request=is_request
            )
        elif quantifier["every"] and not negated:
            inner = _INNER.fullmatch(argument_phrases[1])
            target = None if inner is None else self._categories.get(next(filter(None, inner.groups())))
            if inner is not None and target is not None:
                y = f.Variable("y", target)
                yield (
                    f.ForAll(x, f.Exists(y, make_literal(_X, _Y)))
                    if inner[1]
                    else f.ForPairs(x, y, make_literal(_X, _Y))
                )


def _interpret_quantified(
    quantifier: re.Match[str],
    count: int | None,
    variable: f.Variable,
    body: f.Formula,
    *,
    negated: bool,
    is_request: bool,
) -> Iterator[f.Formula]:
    """Yield the goal that a sentence about all, some or a number of objects states.

    Nothing is yielded for sentences with two meanings, such as "every ... is not".
    """
    if quantifier["every"]:
        if is_request or not negated:
            yield f.ForAll(variable, body)
    elif quantifier["no"] or count is not None:
        if not is_request and not negated:
            yield f.ForAll(variable, f.Not(body)) if count is None else f.Exactly(count, variable, body)
    elif quantifier["number"] is None:
        yield f.Exists(variable, body)


@cache
def _compile_sentence(sentence: str) -> re.Pattern[str]:
    return re.compile(re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+)", re.escape(sentence)))


def _find_arguments_by_sentence_pattern(sentence_pattern: str, text: str) -> Iterator[Sequence[str]]:
    """Yield the words in place of the parameters of a sentence pattern, if a text matches the pattern."""
    match = _compile_sentence(sentence_pattern).fullmatch(text)
    if match is not None:
        named = match.groupdict()
        yield [named[name] for name in make_parameter_names(len(named))]


def _require_one_meaning(meanings: Iterable[f.Formula], text: str) -> f.Formula:
    candidates = list(meanings)
    if len(candidates) != 1:
        raise InputError(f"{text!r} has {len(candidates)} meanings: write a sentence with one meaning")
    return candidates[0]
