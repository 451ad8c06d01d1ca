"""Rewrite planning problems so that a current planner judges them as the tolerant planner of 2024 did.

The published planner success rates come from a translator that accepted undefined names. `normalise` rewrites
a domain that contains operators of an answer, so that any standard planner gives the published verdict. It
refuses problems that every version of the planner refuses. Its rules:

* Operators may name objects of the problem: these objects become constants of the domain.
* Unbound variables get the meaning that `bind_loose_variables` states.
* A literal with an undeclared name gets its own predicate, so that adding it makes only this literal true. A
  comparison with an undeclared name is false.
* A type that is used as a predicate is false. A parameter of several types (``either``) removes its operator.
* Operators without effect are removed, and equal names of operators are made different.

Undeclared types need no rewriting, because no object has them. Types of arguments were never checked.

The planner behind the published numbers (Fast Downward before mid-2024) accepted operators with unbound
variables, but its rule is written down nowhere. `bind_loose_variables` states the rule in two steps, after
which a current planner gives the published answers:

1. An ``exists`` of the precondition that lies only under ``and`` and ``exists`` binds its name in the whole
   operator, like a parameter. Such an ``exists`` in the condition of a ``when`` binds its name in that
   ``when``.
2. A condition's literal with a variable that is still unbound is false. Such a deletion vanishes. Such an
   addition adds `UNBOUND_ADDED` instead: if a plan can reach that atom, the planner crashed.
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
"""Atom that replaces every added atom with an unbound variable."""

Names = frozenset[str]


def bind_loose_variables(action: m.PddlAction) -> m.PddlAction | PddlFinding:
    """Bind every variable of an operator, or return why the reference's planner refused the operator.

    It refused an unbound variable inside a ``forall`` of a condition. An ``exists`` under ``not`` is a
    ``forall``.
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
    """Remove each ``exists`` whose name is not in scope, and append its variable to ``leaked``."""
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
    """Rewrites conditions and effects with unbound variables; ``refused`` collects names without a rule."""

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
    """Read an operator and bind its variables, or return why the planner refuses its domain.

    The result is None for an operator that the planner silently removes: it has no effect, or a parameter of
    several types. The result depends only on the arguments, so it can be cached.
    """
    try:
        return _read(source, header)
    except PddlError as error:
        return PddlFinding(error.offence, error.expected, f"operator {source.name}")


def normalise(header: m.PddlDomain, actions: Iterable[m.PddlAction], problem: m.PddlProblem) -> PlanningTask:
    """Return the rewritten domain and problem. The atom ``fatal`` marks plans on which the planner crashed.

    Args:
        header: the domain without operators.
        actions: the operators that `read_operator` returned.
        problem: the problem of the data set.
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
    """Return the parameters, each name once; None if a parameter has several types."""
    try:
        found = PddlReader(text).variables(group)
    except PddlError as error:
        if error.offence is Violation.UNSUPPORTED:
            return None
        raise
    return tuple({parameter.name: parameter for parameter in found}.values())


def _marked(expression: SExpr, bare: frozenset[str] = frozenset()) -> SExpr:
    """Put question marks before the names that a quantifier binds without a question mark."""
    if isinstance(expression, Symbol):
        text = expression.text
        return Symbol(f"?{text}--bare", expression.offset) if text in bare else expression
    match expression.items:
        case (Symbol("forall" | "exists"), Group(names), _):
            bare |= {name for name in _bound_words(names) if not name.startswith("?")}
    items = tuple([_marked(item, bare) for item in expression.items])
    return Group(items, expression.offset, expression.end)


def _bound_words(names: tuple[SExpr, ...]) -> list[str]:
    """Return the words of a typed list, without the types."""
    words = [item.text if isinstance(item, Symbol) else "" for item in names]
    return [
        word
        for word, before in zip(words, ["", *words], strict=False)
        if word not in {"", "-"} and before != "-"
    ]


def _without_types(condition: f.Formula, header: m.PddlDomain) -> f.Formula:
    """Return the condition in which each type that is used as a predicate is false."""
    types = {m.OBJECT, *(item.name for item in header.types)} - {item.name for item in header.predicates}

    def change(leaf: f.Leaf) -> f.Formula:
        is_type = isinstance(leaf, f.Atom) and leaf.predicate in types and len(leaf.arguments) == 1
        return f.FALSE if is_type else leaf

    return map_leaves(condition, change)


def _with_distinct_names(actions: Iterable[m.PddlAction]) -> list[m.PddlAction]:
    """Return the operators with distinct names: a repeated name gets a number at its end."""
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
    """Moves undeclared constants from the arguments of an atom into the name of its predicate."""

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
