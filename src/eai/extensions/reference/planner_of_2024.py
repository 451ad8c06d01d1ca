"""The reference's tolerance, restated: a domain and problem that a current planner judges as the old one did.

The published planner success rates come from a translator that accepted undefined names. `normalise`
rewrites a domain made of answers so that any standard planner gives the same verdict, or refuses what every
version refuses:

* objects of the problem may be named by operators: they become constants of the domain;
* variables that nothing binds get the meaning that `bind_loose_variables` states;
* names that are declared nowhere: each literal with one gets a predicate of its own, so that adding it makes
  the same literal true and nothing else; a comparison with one is false;
* a type used as a predicate is false; a parameter of several types (``either``) removes its operator;
* operators without effect are left out, equal names are made different.

Undeclared types need no rewriting (no object has them), and types of arguments were never checked.

Operators that use unbound variables the planner behind the published numbers (Fast Downward before mid-2024)
neither refused nor treated by any rule written down; `bind_loose_variables` states the rule as one rewriting,
after which a current planner gives the same answers. Two steps:

1. An ``exists`` of the precondition that lies under nothing but ``and`` and ``exists`` binds its name in the
   whole operator, as if it were a parameter; one in the condition of a ``when`` binds it in that ``when``.
2. Whatever is still unbound makes a condition's literal false, makes a deletion vanish, and turns an addition
   into an addition of `UNBOUND_ADDED`: if that atom can be reached, the planner crashed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.rewriting import map_leaves, negation_normal
from eai.logic.traversal import bound_variables, map_parts, quantify, terms_of
from eai.pddl.check import Declarations, PddlError, PddlFinding, Violation, check_action
from eai.pddl.model import OperatorText
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import Group, PddlReader, SExpr, Symbol, read_group

UNBOUND_ADDED = f.Atom("eai--unbound-added")
"""The atom that stands for adding an atom with an unbound variable."""

Names = frozenset[str]


def bind_loose_variables(action: m.PddlAction) -> m.PddlAction | PddlFinding:
    """The operator with every variable bound, or the offence for which the reference's planner refused it.

    Refused is an unbound variable inside a ``forall`` of a condition (an ``exists`` under ``not`` is one).
    """
    parameters = frozenset(parameter.name for parameter in action.parameters)
    leaked: list[f.Variable] = []
    precondition = _opened(negation_normal(action.precondition), parameters, leaked)
    scope = parameters.union([variable.name for variable in leaked])
    binder = _Binder()
    bound = m.PddlAction(
        name=action.name,
        parameters=(*action.parameters, *leaked),
        precondition=binder.condition(precondition, scope),
        effect=binder.effect(action.effect, scope),
    )
    if binder.refused:
        return PddlFinding(Violation.UNBOUND_VARIABLE, binder.refused[0], f"condition of {action.name}")
    return bound


def _opened(formula: f.Formula, scope: Names, leaked: list[f.Variable]) -> f.Formula:
    """The formula without the existential quantifiers that leak, left to right: those whose name is free."""
    match formula:
        case f.Exists(variable, body) if variable.name not in scope.union([each.name for each in leaked]):
            leaked.append(variable)
            return _opened(body, scope, leaked)
        case f.And() | f.Exists():
            return map_parts(formula, lambda part: _opened(part, scope, leaked))
        case _:
            return formula


@dataclass(slots=True)
class _Binder:
    """Gives what is unbound its meaning; ``refused`` collects the names for which there is none."""

    refused: list[str] = field(default_factory=list)

    def condition(self, formula: f.Formula, scope: Names, *, universal: bool = False) -> f.Formula:
        loose = _loose_terms(terms_of(formula), scope)
        if loose:
            self.refused += loose if universal else ()
            return f.FALSE
        scope = scope.union([variable.name for variable in bound_variables(formula)])
        inside = universal or isinstance(formula, f.ForAll)
        return map_parts(formula, lambda part: self.condition(part, scope, universal=inside))

    def effect(self, effect: m.PddlEffect, scope: Names) -> m.PddlEffect:
        match effect:
            case m.Add(atom):
                return m.Add(UNBOUND_ADDED) if _loose_terms(atom.arguments, scope) else effect
            case m.Delete(atom):
                return m.NO_EFFECT if _loose_terms(atom.arguments, scope) else effect
            case m.Both(parts):
                return m.Both(tuple(self.effect(part, scope) for part in parts))
            case m.Each(variable, part):
                return m.Each(variable, self.effect(part, scope | {variable.name}))
            case m.WhenEffect():
                return self._when(effect, scope)

    def _when(self, effect: m.WhenEffect, scope: Names) -> m.PddlEffect:
        leaked: list[f.Variable] = []
        condition = _opened(negation_normal(effect.condition), scope, leaked)
        inner = scope.union([variable.name for variable in leaked])
        bound: m.PddlEffect = m.WhenEffect(self.condition(condition, inner), self.effect(effect.part, inner))
        return quantify(m.Each, leaked, bound)


def _loose_terms(terms: tuple[f.Term, ...], scope: Names) -> list[str]:
    return [term.name for term in terms if isinstance(term, f.Variable) and term.name not in scope]


_REFUSED = frozenset({Violation.UNKNOWN_PREDICATE, Violation.WRONG_ARITY, Violation.UNSUPPORTED})


def read_operator(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | PddlFinding | None:
    """An operator with all its variables bound, or the offence for which the planner refuses its domain.

    None is one that the planner leaves out without a word: without an effect, or with a parameter of several
    types.

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
    goal = map_leaves(problem.goal, names.leaf)
    domain = replace(
        header,
        constants=objects,
        predicates=(*header.predicates, m.PddlPredicate(UNBOUND_ADDED.predicate, ()), *names.made.values()),
        actions=renamed,
    )
    unbound_added = any(UNBOUND_ADDED in m.effect_atoms(action.effect) for action in renamed)
    return PlanningTask(
        domain=domain,
        problem=replace(problem, objects=(), initial=initial, denied=(), goal=goal),
        fatal=UNBOUND_ADDED if unbound_added else None,
    )


def _read(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | PddlFinding | None:
    place = f"operator {source.name}"
    texts = (source.parameters, source.precondition, source.effect)
    if not all(text.isascii() for text in (source.name, *texts)):
        return PddlFinding(Violation.MALFORMED, "ASCII text", place)
    groups = [read_group(text) for text in texts]
    if any(text[group.end :].strip() for text, group in zip(texts, groups, strict=True)):
        return PddlFinding(Violation.UNBALANCED, "nothing behind a list", place)
    precondition = _without_types(PddlReader(texts[1]).condition(_marked(groups[1])), header)
    effect = PddlReader(texts[2]).whole_effect(_marked(groups[2]))
    effect = m.map_effect(effect, lambda condition: _without_types(condition, header), lambda atom: atom)
    parameters = _parameters(texts[0], groups[0])
    action = m.PddlAction(source.name.lower(), parameters or (), precondition, effect)
    findings = check_action(action, Declarations.of_domain(header))
    for finding in findings:
        if finding.offence in _REFUSED:
            return finding
    if parameters is None or next(m.effect_atoms(effect), None) is None:
        return None
    is_loose = any(finding.offence is Violation.UNBOUND_VARIABLE for finding in findings)
    return bind_loose_variables(action) if is_loose else action


def _parameters(text: str, group: Group) -> tuple[f.Variable, ...] | None:
    """The parameters, each name once; None if one of them has several types."""
    try:
        found = PddlReader(text).variables(group)
    except PddlError as error:
        if error.offence is Violation.UNSUPPORTED:
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

    def change(leaf: f.Leaf) -> f.Formula:
        is_type = isinstance(leaf, f.Atom) and leaf.predicate in types and len(leaf.arguments) == 1
        return f.FALSE if is_type else leaf

    return map_leaves(condition, change)


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

    def action(self, action: m.PddlAction) -> m.PddlAction:
        precondition = map_leaves(action.precondition, self.leaf)
        effect = m.map_effect(action.effect, lambda part: map_leaves(part, self.leaf), self.atom)
        return replace(action, precondition=precondition, effect=effect)

    def leaf(self, leaf: f.Leaf) -> f.Formula:
        if isinstance(leaf, f.Atom):
            return self.atom(leaf)
        return f.FALSE if any(map(self._is_unknown, terms_of(leaf))) else leaf

    def atom(self, atom: f.Atom) -> f.Atom:
        unknown = [(place, term) for place, term in enumerate(atom.arguments) if self._is_unknown(term)]
        if not unknown:
            return atom
        name = "--".join([atom.predicate, *(f"{place}-{term.name}" for place, term in unknown)])
        arguments = tuple(term for term in atom.arguments if not self._is_unknown(term))
        parameters = tuple(f.Variable(f"x{place}") for place in range(len(arguments)))
        self.made[name] = m.PddlPredicate(name, parameters)
        return f.Atom(name, arguments)

    def _is_unknown(self, term: f.Term) -> bool:
        return isinstance(term, f.Constant) and term.name not in self.known
