"""The reference's tolerance, restated: a domain and problem that a current planner judges as the old one did.

The published planner success rates come from a translator that accepted undefined names. `normalise`
rewrites a domain made of answers so that any standard planner gives the same verdict, or refuses what every
version refuses:

* objects of the problem may be named by operators: they become constants of the domain;
* variables that nothing binds get the meaning of `unbound_variables`;
* names that are declared nowhere: each literal with one gets a predicate of its own, so that adding it makes
  the same literal true and nothing else; a comparison with one is false;
* a type used as a predicate is false; a parameter of several types (``either``) removes its operator;
* operators without effect are left out, equal names are made different.

Undeclared types need no rewriting (no object has them), and types of arguments were never checked.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.pddl.check import Declarations, check_action
from eai.pddl.offence import Offence, PddlError, PddlFinding
from eai.pddl.operator_text import OperatorText
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import PddlReader
from eai.pddl.sexpr import Group, SExpr, Symbol, read_group
from eai.reference.unbound_variables import UNBOUND_ADDED, bind_loose_variables

_REFUSED = frozenset({Offence.UNKNOWN_PREDICATE, Offence.WRONG_ARITY, Offence.UNSUPPORTED})


@dataclass(frozen=True, slots=True)
class Dropped:
    """An operator that the planner leaves out without a word."""

    reason: str


def read_operator(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | Dropped | PddlFinding:
    """An operator with all its variables bound, or the offence for which the planner refuses its domain.

    Depends on nothing but its arguments, so that results may be kept.
    """
    try:
        return _read(source, header)
    except PddlError as error:
        return PddlFinding(error.offence, error.expected, f"operator {source.name}")


def normalise(header: m.PddlDomain, actions: Iterable[m.PddlAction], problem: m.PddlProblem) -> PlanningTask:
    """The rewritten domain and problem; fatal is the addition of an atom with an unbound variable.

    Args:
        header: the domain without operators.
        actions: what `read_operator` made of the operators.
        problem: the problem as the data set has it.
    """
    objects = (*header.constants, *problem.objects)
    names = _UnknownNames(frozenset(item.name for item in objects))
    renamed = tuple(map(names.action, _with_distinct_names(actions)))
    initial = tuple(map(names.atom, problem.initial))
    goal = m.map_literals(problem.goal, names.literal)
    domain = replace(
        header,
        constants=objects,
        predicates=(*header.predicates, m.PddlPredicate(UNBOUND_ADDED.predicate, ()), *names.predicates),
        actions=renamed,
    )
    unbound_added = any(UNBOUND_ADDED in m.effect_atoms(action.effect) for action in renamed)
    return PlanningTask(
        domain=domain,
        problem=replace(problem, objects=(), initial=initial, denied=(), goal=goal),
        fatal=UNBOUND_ADDED if unbound_added else None,
    )


def _read(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | Dropped | PddlFinding:
    place = f"operator {source.name}"
    texts = (source.parameters, source.precondition, source.effect)
    if not all(text.isascii() for text in (source.name, *texts)):
        return PddlFinding(Offence.MALFORMED, "non-ASCII text", place)
    groups = [read_group(text) for text in texts]
    if any(text[group.end :].strip() for text, group in zip(texts, groups, strict=True)):
        return PddlFinding(Offence.UNBALANCED, ")", place)
    precondition = _without_types(PddlReader(texts[1]).condition(_marked(groups[1])), header)
    effect = PddlReader(texts[2]).whole_effect(_marked(groups[2]))
    effect = m.map_effect(effect, lambda condition: _without_types(condition, header), _same)
    parameters = _parameters(texts[0], groups[0])
    action = m.PddlAction(source.name.lower(), parameters or (), precondition, effect)
    for finding in check_action(action, Declarations.of(header)):
        if finding.offence in _REFUSED:
            return finding
    if parameters is None:
        return Dropped("a parameter of several types")
    if next(m.effect_atoms(effect), None) is None:
        return Dropped("no effect")
    return bind_loose_variables(action)


def _parameters(text: str, group: Group) -> tuple[f.Variable, ...] | None:
    """The parameters, each name once; None if one of them has several types."""
    try:
        found = PddlReader(text).variables(group)
    except PddlError as error:
        if error.offence is Offence.UNSUPPORTED:
            return None
        raise
    return tuple({parameter.name: parameter for parameter in found}.values())


def _marked(expression: SExpr, bare: frozenset[str] = frozenset()) -> SExpr:
    """The expression with question marks put before names that a quantifier binds without one."""
    if isinstance(expression, Symbol):
        text = expression.text
        return Symbol(f"?{text}--bare", expression.offset) if text in bare else expression
    match expression.items:
        case (Symbol("forall" | "exists"), Group(names), _):
            bare |= {name for name in _bound_words(names) if not name.startswith("?")}
    items = tuple([_marked(item, bare) for item in expression.items])
    return Group(items, expression.offset, expression.end)


def _bound_words(names: tuple[SExpr, ...]) -> list[str]:
    """The words of a typed list that are not types."""
    words = [item.text if isinstance(item, Symbol) else "" for item in names]
    return [
        word
        for word, before in zip(words, ["", *words], strict=False)
        if word not in {"", "-"} and before != "-"
    ]


def _without_types(condition: f.Formula, header: m.PddlDomain) -> f.Formula:
    """The condition with every type that is used as a predicate made false."""
    types = {m.OBJECT, *(item.name for item in header.types)} - {item.name for item in header.predicates}

    def change(literal: f.Atom | f.Equals) -> f.Formula:
        is_type = isinstance(literal, f.Atom) and literal.predicate in types and len(literal.arguments) == 1
        return f.FALSE if is_type else literal

    return m.map_literals(condition, change)


def _same(atom: f.Atom) -> f.Atom:
    return atom


def _with_distinct_names(actions: Iterable[m.PddlAction]) -> list[m.PddlAction]:
    """The operators, a name that was there before with a number behind it."""
    found: dict[str, m.PddlAction] = {}
    for action in actions:
        name, number = action.name, 1
        while name in found:
            number += 1
            name = f"{action.name}--{number}"
        found[name] = replace(action, name=name)
    return list(found.values())


@dataclass(slots=True)
class _UnknownNames:
    """Moves constants that no one declared from the arguments into the predicate."""

    known: frozenset[str]
    made: dict[str, m.PddlPredicate] = field(default_factory=dict)

    @property
    def predicates(self) -> tuple[m.PddlPredicate, ...]:
        """The predicates that were made on the way."""
        return tuple(self.made.values())

    def action(self, action: m.PddlAction) -> m.PddlAction:
        precondition = m.map_literals(action.precondition, self.literal)
        return replace(action, precondition=precondition, effect=self._effect(action.effect))

    def literal(self, literal: f.Atom | f.Equals) -> f.Formula:
        if isinstance(literal, f.Atom):
            return self.atom(literal)
        return f.FALSE if self._is_unknown(literal.left) or self._is_unknown(literal.right) else literal

    def atom(self, atom: f.Atom) -> f.Atom:
        unknown = [(place, term) for place, term in enumerate(atom.arguments) if self._is_unknown(term)]
        if not unknown:
            return atom
        name = "--".join([atom.predicate, *(f"{place}-{term.name}" for place, term in unknown)])
        arguments = tuple(term for term in atom.arguments if not self._is_unknown(term))
        parameters = tuple(f.Variable(f"x{place}") for place in range(len(arguments)))
        self.made[name] = m.PddlPredicate(name, parameters)
        return f.Atom(name, arguments)

    def _effect(self, effect: m.PddlEffect) -> m.PddlEffect:
        return m.map_effect(effect, lambda condition: m.map_literals(condition, self.literal), self.atom)

    def _is_unknown(self, term: f.Term) -> bool:
        return isinstance(term, f.Constant) and term.name not in self.known
