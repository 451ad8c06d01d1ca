"""The exact text of actions: every check and every effect of a declaration, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.abilities.wording import is_property
from eai.english.english import English, sentences_of, turned
from eai.errors import InputError
from eai.logic.traversal import walk
from eai.world.derived import Defined
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.frame import AGENT
from eai.world.operator import Operator, conditions_of
from eai.world.vocabulary import Vocabulary, parameters


@dataclass(frozen=True)
class ExactText:
    """Says what operators of one vocabulary need and do.

    Attributes:
        vocabulary: the vocabulary.
        english: what predicates mean.
        word: what a category or a property is called.
    """

    vocabulary: Vocabulary
    english: English
    word: Callable[[str], str] = str

    def needs(self, operator: Operator) -> str:
        """Return the conditions of an action; of several tries what one of them needs."""
        tried = [f.And(each.conditions) for each in operator.tries]
        none = f.Not(f.Or(tuple([each.condition for each in operator.tries])))
        asked = [check.condition for check in operator.checks]
        if tried:
            asked.append(f.Or((*tried, none)))
        return "; ".join(dict.fromkeys(map(self.condition, asked))) or "always"

    def does(self, operator: Operator) -> str:
        """Return the effects of an action; ``nothing changes`` if it has no effect."""
        tried = [When(f.And(each.conditions), each.effects) for each in operator.tries]
        return "; ".join(self._all((*tried, *operator.effects))) or "nothing changes"

    def _all(self, effects: Sequence[Effect]) -> Iterator[str]:
        place = 0
        while place < len(effects):
            is_pair = place + 1 < len(effects) and _is_mirror(effects[place], effects[place + 1])
            yield self._effect(effects[place]) + (", and the other way round" if is_pair else "")
            place += 1 + is_pair

    def _effect(self, effect: Effect) -> str:
        match effect:
            case Add(atom):
                return self.condition(atom)
            case Delete(atom):
                return self.condition(f.Not(atom))
            case When(condition, effects, otherwise):
                text = f"if {self.condition(condition)}: {self._block(effects)}"
                return f"{text}, otherwise: {self._block(otherwise)}" if otherwise else text
            case ForEach(variable, condition, effects):
                return (
                    f"for every {variable.name} for which {self.condition(condition)}: {self._block(effects)}"
                )
            case Let(variable, condition, effects):
                chosen = f"for the first {variable.name}, if any, such that {self.condition(condition)}"
                return f"{chosen}: {self._block(effects)}"
            case _:
                assert_never(effect)

    def _block(self, effects: Sequence[Effect]) -> str:
        return f"[{'; '.join(self._all(effects))}]"

    def condition(self, formula: f.Formula) -> str:
        """Return the meaning of a condition of the declaration."""
        match formula:
            case f.Atom():
                return self._atom(formula)
            case f.Not(f.Atom() as atom):
                return self._atom(atom, negated=True)
            case f.Not(f.Not(operand)):
                return self.condition(operand)
            case f.Not(f.Exists(variable, body)) if not isinstance(body, f.Equals):
                return f"there is no {self._ranging(variable)} such that {self.condition(body)}"
            case f.Not(operand):
                return f"it is not so that {self.condition(operand)}"
            case f.And(operands):
                return self._joined(operands, "and")
            case f.Or(operands):
                return self._joined(operands, "or")
            case f.Implies(premise, conclusion):
                return f"({self.condition(conclusion)} or it is not so that {self.condition(premise)})"
        return self._of_objects(formula)

    def _of_objects(self, formula: f.Formula) -> str:
        """Return the meaning of a condition that ranges over objects, or compares them."""
        match formula:
            case f.Exists(f.Variable(_, str() as category), f.Equals(_, other)):
                return f"{_name(other)} is of the kind {self.word(category)}"
            case f.Exists(variable, body):
                return f"there is some {self._ranging(variable)} such that {self.condition(body)}"
            case f.ForAll(variable, body):
                return f"for every {self._ranging(variable)}, {self.condition(body)}"
            case f.Equals(left, right):
                return f"{_name(left)} is {_name(right)}"
        raise InputError(f"there is no sentence for {type(formula).__name__}")

    def _ranging(self, variable: f.Variable) -> str:
        of_kind = "" if variable.category is None else f" of the kind {self.word(variable.category)}"
        return f"{variable.name}{of_kind}"

    def definitions(self, predicates: Iterable[str]) -> Iterator[str]:
        """Return the meanings of those of some predicates that are derived by a formula."""
        for name in predicates:
            derived = self.vocabulary.derived_by_name.get(name)
            if isinstance(derived, Defined):
                atom = f.Atom(name, tuple(derived.parameters))
                yield f"{self.condition(atom)} if {self.condition(derived.definition)}"

    def spoken_of(self, predicates: Sequence[str], operators: Iterable[Operator]) -> Sequence[str]:
        """Some predicates, those that operators ask for, and those by which these are derived, each once."""
        formulas = [formula for operator in operators for formula in conditions_of(operator)]
        pending = [*predicates, *chain(*map(_predicates, formulas))]
        found: dict[str, None] = {}
        while pending:
            name = pending.pop(0)
            derived = self.vocabulary.derived_by_name.get(name)
            if name not in found and isinstance(derived, Defined):
                pending += _predicates(derived.definition)
            found[name] = None
        return list(found)

    def _joined(self, operands: Iterable[f.Formula], word: str) -> str:
        texts = list(dict.fromkeys(map(self.condition, operands)))
        return texts[0] if len(texts) == 1 else f"({f' {word} '.join(texts)})"

    def _atom(self, atom: f.Atom, *, negated: bool = False) -> str:
        sentence = self._sentence(atom.predicate)
        values = dict(zip(parameters(len(atom.arguments)), map(_name, atom.arguments), strict=True))
        if negated and not sentence.startswith("{x} "):
            return f"it is not so that {sentence.format(**values)}"
        return turned(sentence, negated=negated).format(**values)

    def _sentence(self, predicate: str) -> str:
        if is_property(self.vocabulary.stored(predicate)):
            return f"{{x}} has the property {self.word(predicate)}"
        return sentences_of(predicate, self.vocabulary.arity(predicate) or 0, self.english)[0]


def _predicates(formula: f.Formula) -> list[str]:
    return [part.predicate for part in walk(formula) if isinstance(part, f.Atom)]


def _name(term: f.Term) -> str:
    if term == AGENT:
        return "the agent"
    return "anything" if term == ANYTHING else term.name


def _is_mirror(effect: Effect, other: Effect) -> bool:
    """Whether the other effect says the same of two objects the other way round."""
    match effect, other:
        case (Add(atom), Add(mirrored)) | (Delete(atom), Delete(mirrored)):
            arguments = atom.arguments
            return (
                len(arguments) == 2
                and atom.predicate == mirrored.predicate
                and arguments[::-1] == mirrored.arguments
            )
    return False
