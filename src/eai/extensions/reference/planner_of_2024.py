"""Rewrite planning problems so that a current planner judges them as the tolerant planner of 2024 did.

The published planner success rates come from a translator that accepted undefined names. `read_operator` and
`make_task_imitating_planner_of_2024` rewrite a domain that contains operators of an answer. Then any standard
planner gives the published verdict. They refuse operators that every version of the planner refuses. The
rules:

* Operators may name objects of the problem: these objects become constants of the domain.
* Unbound variables get the meaning that `bind_unbound_variables` states.
* A literal with an undeclared name gets its own predicate, so that adding it makes only this literal true. A
  comparison with an undeclared name is false.
* A type that is used as a predicate is false. A parameter of several types (``either``) removes its operator.
* Operators without effect are removed, and equal names of operators are made different.

Undeclared types need no rewriting, because no object has them. Types of arguments were never checked.

The planner behind the published numbers (Fast Downward before mid-2024) accepted operators with unbound
variables, but its rule is written down nowhere. `bind_unbound_variables` states the rule in two steps, after
which a current planner gives the published answers:

1. An ``exists`` of the precondition that lies only under ``and`` and ``exists`` binds its name in the whole
   operator, like a parameter. Such an ``exists`` in the condition of a ``when`` binds its name in that
   ``when``.
2. A condition's literal with a variable that is still unbound is false. A deletion with such a variable
   vanishes. An addition with such a variable adds `UNBOUND_ADDED` instead: if a plan can reach that atom, the
   planner crashed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.rewriting import map_leaves, push_negations_inwards
from eai.logic.traversal import get_bound_variables, get_terms, map_subformulas, wrap_in_quantifiers
from eai.pddl.check import PddlDeclarations, PddlError, PddlFinding, PddlViolationKind, check_action
from eai.pddl.model import OperatorText
from eai.pddl.planning import PlanningTask
from eai.pddl.reader import ExpressionList, PddlReader, SExpr, Symbol, read_group

UNBOUND_ADDED = f.Atom("eai--unbound-added")
"""Atom that an effect adds in place of an atom with an unbound variable."""

Names = frozenset[str]


def bind_unbound_variables(action: m.PddlAction) -> m.PddlAction | PddlFinding:
    """Bind every variable of an operator, or return why the published planner refused the operator.

    That planner (Fast Downward before mid-2024) refused an unbound variable inside a ``forall`` of a
    condition. An ``exists`` under ``not`` counts as a ``forall``.
    """
    parameters = frozenset(parameter.name for parameter in action.parameters)
    leaked: list[f.Variable] = []
    precondition = _remove_exists_of_new_variables(
        push_negations_inwards(action.precondition), parameters, leaked
    )
    scope = parameters.union([variable.name for variable in leaked])
    binder = _VariableBinder()
    bound = m.PddlAction(
        name=action.name,
        parameters=(*action.parameters, *leaked),
        precondition=binder.replace_unbound_literals_by_false(precondition, scope),
        effect=binder.replace_effects_that_have_unbound_variables(action.effect, scope),
    )
    if binder.refused:
        return PddlFinding(
            PddlViolationKind.UNBOUND_VARIABLE, binder.refused[0], f"condition of {action.name}"
        )
    return bound


def _remove_exists_of_new_variables(
    formula: f.Formula, bound_names: Names, removed: list[f.Variable]
) -> f.Formula:
    """Remove each ``exists`` with a new variable, and append the variable to ``removed``.

    A variable is new if its name is not in ``bound_names`` and not yet in ``removed``.
    """
    match formula:
        case f.Exists(variable, body) if variable.name not in bound_names.union(
            [bound.name for bound in removed]
        ):
            removed.append(variable)
            return _remove_exists_of_new_variables(body, bound_names, removed)
        case f.And() | f.Exists():
            return map_subformulas(
                formula, lambda part: _remove_exists_of_new_variables(part, bound_names, removed)
            )
        case _:
            return formula


@dataclass(slots=True)
class _VariableBinder:
    """Replaces literals and effects that contain unbound variables.

    A literal of a condition becomes false, a deletion vanishes, and an addition adds `UNBOUND_ADDED` instead.
    ``refused`` collects the names of unbound variables inside a ``forall`` of a condition. The planner
    refuses an operator that has such a variable.
    """

    refused: list[str] = field(default_factory=list)

    def replace_unbound_literals_by_false(
        self, formula: f.Formula, scope: Names, *, is_inside_forall: bool = False
    ) -> f.Formula:
        loose = _list_unbound_names(get_terms(formula), scope)
        if loose:
            self.refused += loose if is_inside_forall else ()
            return f.FALSE
        scope = scope.union([variable.name for variable in get_bound_variables(formula)])
        inside = is_inside_forall or isinstance(formula, f.ForAll)
        return map_subformulas(
            formula,
            lambda part: self.replace_unbound_literals_by_false(part, scope, is_inside_forall=inside),
        )

    def replace_effects_that_have_unbound_variables(self, effect: m.PddlEffect, scope: Names) -> m.PddlEffect:
        match effect:
            case m.Add(atom):
                return m.Add(UNBOUND_ADDED) if _list_unbound_names(atom.arguments, scope) else effect
            case m.Delete(atom):
                return m.NO_EFFECT if _list_unbound_names(atom.arguments, scope) else effect
            case m.AndEffect(parts):
                return m.AndEffect(
                    tuple(self.replace_effects_that_have_unbound_variables(part, scope) for part in parts)
                )
            case m.ForAllEffect(variable, part):
                return m.ForAllEffect(
                    variable, self.replace_effects_that_have_unbound_variables(part, scope | {variable.name})
                )
            case m.WhenEffect():
                return self._replace_unbound_parts_of_when_effect(effect, scope)

    def _replace_unbound_parts_of_when_effect(self, effect: m.WhenEffect, scope: Names) -> m.PddlEffect:
        leaked: list[f.Variable] = []
        condition = _remove_exists_of_new_variables(push_negations_inwards(effect.condition), scope, leaked)
        inner = scope.union([variable.name for variable in leaked])
        bound: m.PddlEffect = m.WhenEffect(
            self.replace_unbound_literals_by_false(condition, inner),
            self.replace_effects_that_have_unbound_variables(effect.part, inner),
        )
        return wrap_in_quantifiers(m.ForAllEffect, leaked, bound)


def _list_unbound_names(terms: tuple[f.Term, ...], scope: Names) -> list[str]:
    return [term.name for term in terms if isinstance(term, f.Variable) and term.name not in scope]


_REFUSED = frozenset(
    {PddlViolationKind.UNKNOWN_PREDICATE, PddlViolationKind.WRONG_ARITY, PddlViolationKind.UNSUPPORTED}
)


def read_operator(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | PddlFinding | None:
    """Read an operator and bind its variables, or return why the planner refuses the operator.

    The result is None for an operator that the planner removes without a message: an operator without effect,
    or with a parameter of several types. The result depends only on the arguments, so it can be cached.
    """
    try:
        return _read_and_check_operator(source, header)
    except PddlError as error:
        return PddlFinding(error.offence, error.expected, f"operator {source.name}")


def make_task_imitating_planner_of_2024(
    header: m.PddlDomain, actions: Iterable[m.PddlAction], problem: m.PddlProblem
) -> PlanningTask:
    """Return a planning task on which a current planner gives the result of the published planner.

    The published planner (Fast Downward before mid-2024) crashed if a plan could reach an effect that
    adds an atom with an unbound variable. In the returned task, such an effect adds the atom ``fatal``.

    Args:
        header: the domain without operators.
        actions: the operators that `read_operator` returned.
        problem: the problem of the data set.
    """
    objects = (*header.constants, *problem.objects)
    names = _UndeclaredConstantToPredicateRewriter(frozenset(item.name for item in objects))
    renamed = tuple(map(names.move_constants_into_predicate_names, _make_names_distinct(actions)))
    initial = tuple(map(names.remove_undeclared_constants_from_atom, problem.initial))
    goal = map_leaves(problem.goal, names.remove_undeclared_constants_from_leaf)
    domain = replace(
        header,
        constants=objects,
        predicates=(
            *header.predicates,
            m.PddlPredicate(UNBOUND_ADDED.predicate, ()),
            *names.new_predicates.values(),
        ),
        actions=renamed,
    )
    unbound_added = any(UNBOUND_ADDED in m.find_effect_atoms(action.effect) for action in renamed)
    return PlanningTask(
        domain=domain,
        problem=replace(problem, objects=(), initial=initial, denied=(), goal=goal),
        fatal=UNBOUND_ADDED if unbound_added else None,
    )


def _read_and_check_operator(source: OperatorText, header: m.PddlDomain) -> m.PddlAction | PddlFinding | None:
    location = f"operator {source.name}"
    texts = (source.parameters, source.precondition, source.effect)
    if not all(text.isascii() for text in (source.name, *texts)):
        return PddlFinding(PddlViolationKind.MALFORMED, "ASCII text", location)
    groups = [read_group(text) for text in texts]
    if any(text[group.end :].strip() for text, group in zip(texts, groups, strict=True)):
        return PddlFinding(PddlViolationKind.UNBALANCED, "nothing behind a list", location)
    precondition = _make_types_used_as_predicates_false(
        PddlReader(texts[1]).read_condition_or_empty(_add_question_marks_to_bound_names(groups[1])), header
    )
    effect = PddlReader(texts[2]).read_effect_or_empty(_add_question_marks_to_bound_names(groups[2]))
    effect = m.map_effect(
        effect, lambda condition: _make_types_used_as_predicates_false(condition, header), lambda atom: atom
    )
    parameters = _read_parameters(texts[0], groups[0])
    action = m.PddlAction(source.name.lower(), parameters or (), precondition, effect)
    findings = check_action(action, PddlDeclarations.from_domain(header))
    for finding in findings:
        if finding.offence in _REFUSED:
            return finding
    if parameters is None or next(m.find_effect_atoms(effect), None) is None:
        return None
    is_loose = any(finding.offence is PddlViolationKind.UNBOUND_VARIABLE for finding in findings)
    return bind_unbound_variables(action) if is_loose else action


def _read_parameters(text: str, group: ExpressionList) -> tuple[f.Variable, ...] | None:
    """Return an operator's parameters; None if a parameter has several types.

    Parameters with the same name become one, with the last of their types.
    """
    try:
        variables = PddlReader(text).read_variables(group)
    except PddlError as error:
        if error.offence is PddlViolationKind.UNSUPPORTED:
            return None
        raise
    return tuple({parameter.name: parameter for parameter in variables}.values())


def _add_question_marks_to_bound_names(
    expression: SExpr, unmarked_names: frozenset[str] = frozenset()
) -> SExpr:
    """Put question marks before the names that a quantifier binds without a question mark."""
    if isinstance(expression, Symbol):
        text = expression.text
        return Symbol(f"?{text}--bare", expression.offset) if text in unmarked_names else expression
    match expression.items:
        case (Symbol("forall" | "exists"), ExpressionList(names), _):
            unmarked_names |= {name for name in _list_variable_names(names) if not name.startswith("?")}
    items = tuple([_add_question_marks_to_bound_names(item, unmarked_names) for item in expression.items])
    return ExpressionList(items, expression.offset, expression.end)


def _list_variable_names(typed_list: tuple[SExpr, ...]) -> list[str]:
    words = [item.text if isinstance(item, Symbol) else "" for item in typed_list]
    return [
        word
        for word, before in zip(words, ["", *words], strict=False)
        if word not in {"", "-"} and before != "-"
    ]


def _make_types_used_as_predicates_false(condition: f.Formula, header: m.PddlDomain) -> f.Formula:
    """Return a condition in which each atom whose predicate is the name of a type becomes false."""
    types = {m.OBJECT, *(item.name for item in header.types)} - {item.name for item in header.predicates}

    def replace_type_atom_by_false(leaf: f.Leaf) -> f.Formula:
        is_type = isinstance(leaf, f.Atom) and leaf.predicate in types and len(leaf.arguments) == 1
        return f.FALSE if is_type else leaf

    return map_leaves(condition, replace_type_atom_by_false)


def _make_names_distinct(actions: Iterable[m.PddlAction]) -> list[m.PddlAction]:
    renamed: dict[str, m.PddlAction] = {}
    for action in actions:
        name, number = action.name, 1
        while name in renamed:
            number += 1
            name = f"{action.name}--{number}"
        renamed[name] = replace(action, name=name)
    return list(renamed.values())


@dataclass(slots=True)
class _UndeclaredConstantToPredicateRewriter:
    """Moves undeclared constants from the arguments of an atom into the name of its predicate."""

    declared: frozenset[str]
    new_predicates: dict[str, m.PddlPredicate] = field(default_factory=dict)

    def move_constants_into_predicate_names(self, action: m.PddlAction) -> m.PddlAction:
        precondition = map_leaves(action.precondition, self.remove_undeclared_constants_from_leaf)
        effect = m.map_effect(
            action.effect,
            lambda part: map_leaves(part, self.remove_undeclared_constants_from_leaf),
            self.remove_undeclared_constants_from_atom,
        )
        return replace(action, precondition=precondition, effect=effect)

    def remove_undeclared_constants_from_leaf(self, leaf: f.Leaf) -> f.Formula:
        if isinstance(leaf, f.Atom):
            return self.remove_undeclared_constants_from_atom(leaf)
        return f.FALSE if any(map(self._is_undeclared_constant, get_terms(leaf))) else leaf

    def remove_undeclared_constants_from_atom(self, atom: f.Atom) -> f.Atom:
        unknown = [
            (place, term) for place, term in enumerate(atom.arguments) if self._is_undeclared_constant(term)
        ]
        if not unknown:
            return atom
        name = "--".join([atom.predicate, *(f"{place}-{term.name}" for place, term in unknown)])
        arguments = tuple(term for term in atom.arguments if not self._is_undeclared_constant(term))
        parameters = tuple(f.Variable(f"x{place}") for place in range(len(arguments)))
        self.new_predicates[name] = m.PddlPredicate(name, parameters)
        return f.Atom(name, arguments)

    def _is_undeclared_constant(self, term: f.Term) -> bool:
        return isinstance(term, f.Constant) and term.name not in self.declared
