"""Execute operators on explicit states with the plain semantics of PDDL, to check every plan.

A state is the set of the true atoms of predicates that are not derived. A quantifier skips objects that
cannot affect its truth. An index of the state finds the other objects, from the atoms in the quantifier's
body. Derived predicates that depend on themselves are computed as least fixpoints. The search (`grounding`,
`search`) has separate code for conditions and effects. So a mistake in the search is found when its plans are
executed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.semantics import find_possible_values_of_variable, unite_value_sets
from eai.logic.signature import describe_arity
from eai.logic.traversal import find_predicates
from eai.planning.search import SearchEffort

PddlState = frozenset[f.Atom]
Valuation = Mapping[str, str]
"""Mapping from the name of each variable to its object."""

_Arguments = tuple[str, ...]


class DerivedPredicates:
    """The axioms of a domain, by the derived predicates that they define.

    Attributes:
        axioms: mapping from each derived predicate to its axioms. The predicate holds if the condition of any
            of them holds.
        cycles: mapping from each recursive predicate to its cycle: all predicates on which it depends and
            which depend on it, itself included.
    """

    def __init__(self, axioms: Iterable[m.PddlAxiom]) -> None:
        self.axioms: dict[str, list[m.PddlAxiom]] = {}
        for axiom in axioms:
            self.axioms.setdefault(axiom.name, []).append(axiom)
        below = {name: self._find_derived_predicate_dependencies(name) for name in self.axioms}
        self.cycles = {
            name: tuple([other for other in below[name] if name in below[other]])
            for name in self.axioms
            if name in below[name]
        }

    def _find_derived_predicate_dependencies(self, predicate: str) -> tuple[str, ...]:
        """Return the derived predicates on which a predicate depends.

        The predicate itself is among them only if it is recursive.
        """
        reachable: dict[str, None] = {}
        waiting = [predicate]
        while waiting:
            for axiom in self.axioms[waiting.pop()]:
                names = find_predicates(axiom.condition)
                new = [name for name in names if name in self.axioms and name not in reachable]
                reachable |= dict.fromkeys(new)
                waiting += new
        return tuple(reachable)


class _ConditionEvaluatorInState:
    """Evaluates conditions in one state.

    Args:
        state: the true atoms of predicates that are not derived.
        derived: the derived predicates.
        objects: the objects of each type.
        looks: the budget of objects that quantifiers may visit, shared with other states; unlimited by
            default.
    """

    def __init__(
        self,
        state: PddlState,
        derived: DerivedPredicates,
        objects: Mapping[str, tuple[str, ...]],
        looks: SearchEffort | None = None,
    ) -> None:
        self._looks = looks or SearchEffort()
        self._axioms = derived.axioms
        self._cycles = derived.cycles
        self._objects = objects
        self._rows: dict[str, set[_Arguments]] = {}
        self._indexed: dict[tuple[str, int], dict[str, list[_Arguments]]] = {}
        self._known: dict[tuple[str, _Arguments], bool] = {}
        for atom in state:
            self._rows.setdefault(atom.predicate, set()).add(tuple([term.name for term in atom.arguments]))

    def holds(self, formula: f.Formula, binding: Valuation) -> bool:
        """Whether a condition holds.

        Raises:
            ValueError: a part of the formula has no PDDL form, or a variable is unbound.
        """
        match formula:
            case f.Atom(predicate, arguments):
                return self._is_predicate_true(
                    predicate, tuple([resolve_term(term, binding) for term in arguments])
                )
            case f.Equals(left, right):
                return resolve_term(left, binding) == resolve_term(right, binding)
            case f.Not(operand):
                return not self.holds(operand, binding)
            case f.And(operands):
                return all(self.holds(operand, binding) for operand in operands)
            case f.Or(operands):
                return any(self.holds(operand, binding) for operand in operands)
            case f.Implies(premise, conclusion):
                return not self.holds(premise, binding) or self.holds(conclusion, binding)
            case f.ForAll(variable, body):
                counter = self.generate_bindings(variable, f.Not(body), binding)
                return all(self.holds(body, inner) for inner in counter)
            case f.Exists(variable, body):
                return any(
                    self.holds(body, inner) for inner in self.generate_bindings(variable, body, binding)
                )
            case _:
                raise ValueError(
                    f"{type(formula).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
                )

    def generate_bindings(
        self, variable: f.Variable, body: f.Formula, binding: Valuation
    ) -> Iterator[Valuation]:
        """Yield a copy of a binding for each object with which a variable may satisfy a condition.

        In the copy, the variable has this object. Objects come in the order of their declaration.
        """
        members = self._objects[m.get_variable_type(variable)]
        inner = {name: value for name, value in binding.items() if name != variable.name}
        candidates = find_possible_values_of_variable(
            body, variable.name, inner, True, self._find_possible_values_of_argument
        )
        names = [name for name in members if candidates is None or name in candidates]
        return (
            {**inner, variable.name: name} for name in self._looks.yield_objects_until_effort_limit(names)
        )

    def _is_predicate_true(self, predicate: str, arguments: _Arguments) -> bool:
        if predicate not in self._axioms:
            return arguments in self._rows.get(predicate, ())
        self._store_true_atoms_of_recursive_predicate(predicate)
        if predicate in self._rows:
            return arguments in self._rows[predicate]
        key = (predicate, arguments)
        holds = self._known.get(key)
        if holds is None:
            axioms = self._axioms[predicate]
            holds = self._known[key] = any(
                self.holds(each.condition, each.map_parameters(arguments)) for each in axioms
            )
        return holds

    def _store_true_atoms_of_recursive_predicate(self, predicate: str) -> None:
        """Store all true rows of a recursive derived predicate, and of the other predicates in its cycle.

        A row is a tuple of arguments.
        """
        cycle = self._cycles.get(predicate)
        if cycle is None or predicate in self._rows:
            return
        for name in cycle:
            self._rows[name] = set()
        grown = True
        while grown:
            grown = False
            for name in cycle:
                new = {row for axiom in self._axioms[name] for row in self._derive_true_arguments(axiom)}
                grown = grown or not new <= self._rows[name]
                self._rows[name] |= new
                self._indexed.clear()
                self._known.clear()

    def _derive_true_arguments(self, axiom: m.PddlAxiom) -> Iterator[_Arguments]:
        bindings: list[Valuation] = [{}]
        for parameter in axiom.parameters:
            bindings = [
                each for b in bindings for each in self.generate_bindings(parameter, axiom.condition, b)
            ]
        for binding in bindings:
            if self.holds(axiom.condition, binding):
                yield tuple([binding[parameter.name] for parameter in axiom.parameters])

    def _find_possible_values_of_argument(
        self, atom: f.Atom | f.Occurs, argument_index: int, binding: Valuation
    ) -> Set[str] | None:
        """Return the objects that an argument of an atom may have if the atom holds; None for any object.

        Variables that `binding` does not bind may have any value.
        """
        if isinstance(atom, f.Occurs):
            return None
        values = [_find_value(term, binding) for term in atom.arguments]
        if atom.predicate in self._axioms:
            self._store_true_atoms_of_recursive_predicate(atom.predicate)
            if atom.predicate not in self._rows:
                return self._find_argument_values_of_derived_predicate(atom.predicate, argument_index, values)
        return {row[argument_index] for row in self._find_matching_rows(atom.predicate, values)}

    def _find_argument_values_of_derived_predicate(
        self, predicate: str, argument_index: int, known_arguments: Sequence[str | None]
    ) -> Set[str] | None:
        supports = []
        for axiom in self._axioms[predicate]:
            names = [parameter.name for parameter in axiom.parameters]
            binding = {n: value for n, value in zip(names, known_arguments, strict=True) if value is not None}
            supports.append(
                find_possible_values_of_variable(
                    axiom.condition,
                    names[argument_index],
                    binding,
                    True,
                    self._find_possible_values_of_argument,
                )
            )
        return unite_value_sets(supports)

    def _find_matching_rows(self, predicate: str, values: Sequence[str | None]) -> Iterable[_Arguments]:
        """Yield the rows of arguments with given values that make a predicate true; None allows any value."""
        rows: Iterable[_Arguments] = self._rows.get(predicate, ())
        for argument_index, value in enumerate(values):
            if value is not None:
                rows = self._index_rows(predicate, argument_index).get(value, ())
                break
        return (row for row in rows if all(value in (None, x) for value, x in zip(values, row, strict=True)))

    def _index_rows(self, predicate: str, argument_index: int) -> Mapping[str, list[_Arguments]]:
        rows_by_value = self._indexed.get((predicate, argument_index))
        if rows_by_value is None:
            rows_by_value = self._indexed[predicate, argument_index] = {}
            for row in self._rows.get(predicate, ()):
                rows_by_value.setdefault(row[argument_index], []).append(row)
        return rows_by_value


def resolve_term(term: f.Term, binding: Valuation) -> str:
    """Return the object that a variable or constant stands for.

    Raises:
        ValueError: the term is an unbound variable.
    """
    if isinstance(term, f.Constant):
        return term.name
    bound = binding.get(term.name)
    if bound is None:
        raise ValueError(f"variable ?{term.name} is not bound: make it a parameter, or quantify over it")
    return bound


def _find_value(term: f.Term, binding: Valuation) -> str | None:
    return term.name if isinstance(term, f.Constant) else binding.get(term.name)


@dataclass(frozen=True, slots=True)
class PlanStep:
    """One step of a plan: an operator and its objects."""

    action: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join((self.action, *self.arguments))


class PddlPlanExecutor:
    """Executes plans of one domain and problem.

    Args:
        domain: the operators.
        problem: the objects, the initial state and the goal.
        effort: the budget: number of objects that quantifiers may visit; unlimited by default.
    """

    def __init__(
        self, domain: m.PddlDomain, problem: m.PddlProblem, effort: SearchEffort | None = None
    ) -> None:
        self._looks = effort
        self._actions = {action.name: action for action in domain.actions}
        self._objects = m.group_objects_by_type(domain, problem)
        self._problem = problem
        self._derived = DerivedPredicates(domain.axioms)
        self._last: tuple[PddlState, _ConditionEvaluatorInState] | None = None

    @property
    def initial_state(self) -> PddlState:
        """The initial state."""
        return frozenset(self._problem.initial)

    def find_failed_step(self, plan: Sequence[PlanStep]) -> tuple[int, str] | None:
        """Return the index of the step at which a plan fails, with the reason, or None if the plan succeeds.

        Steps count from 0. If all steps run but the goal is missed, the index is the length of the plan.
        """
        state = self.initial_state
        for index, step in enumerate(plan):
            result = self.execute_step(state, step)
            if isinstance(result, str):
                return index, result
            state = result
        return None if self.holds(self._problem.goal, state, {}) else (len(plan), "goal not reached")

    def execute_step(self, state: PddlState, step: PlanStep) -> PddlState | str:
        """Return the state after a step, or the reason why the step is impossible, in words."""
        action = self._actions.get(step.action)
        if action is None:
            return f"no operator {step.action}"
        if len(step.arguments) != len(action.parameters):
            return describe_arity(step.action, len(action.parameters), "object")
        for parameter, name in zip(action.parameters, step.arguments, strict=True):
            if name not in self._objects[m.get_variable_type(parameter)]:
                return f"{name} is no {m.get_variable_type(parameter)}"
        evaluation = self._get_condition_evaluator(state)
        binding = dict(zip([p.name for p in action.parameters], step.arguments, strict=True))
        if not evaluation.holds(action.precondition, binding):
            return f"the precondition of ({step}) does not hold"
        changes = list(_find_changes(action.effect, evaluation, binding))
        deleted = {change.atom for change in changes if isinstance(change, m.Delete)}
        added = {change.atom for change in changes if isinstance(change, m.Add)}
        return (state - deleted) | added

    def holds(self, formula: f.Formula, state: PddlState, binding: Valuation) -> bool:
        """Whether a condition holds in a state.

        Raises:
            ValueError: a part of the formula has no PDDL form, or a variable is unbound.
        """
        return self._get_condition_evaluator(state).holds(formula, binding)

    def _get_condition_evaluator(self, state: PddlState) -> _ConditionEvaluatorInState:
        """Return the evaluator of conditions in a state; the last evaluator is cached."""
        if self._last is None or self._last[0] is not state:
            self._last = state, _ConditionEvaluatorInState(state, self._derived, self._objects, self._looks)
        return self._last[1]


def _find_changes(
    effect: m.PddlEffect, evaluation: _ConditionEvaluatorInState, binding: Valuation
) -> Iterator[m.Add | m.Delete]:
    """Yield the ground additions and deletions of an effect in a state.

    All conditions are evaluated in the state before the effect.
    """
    match effect:
        case m.Add(atom):
            yield m.Add(_ground_atom(atom, binding))
        case m.Delete(atom):
            yield m.Delete(_ground_atom(atom, binding))
        case m.AndEffect(parts):
            for part in parts:
                yield from _find_changes(part, evaluation, binding)
        case m.ForAllEffect(variable, part):
            for inner in evaluation.generate_bindings(
                variable, _find_condition_needed_for_any_change(part, {variable.name}), binding
            ):
                yield from _find_changes(part, evaluation, inner)
        case m.WhenEffect(condition, part):
            if evaluation.holds(condition, binding):
                yield from _find_changes(part, evaluation, binding)


def _find_condition_needed_for_any_change(effect: m.PddlEffect, bound_names: set[str]) -> f.Formula:
    """Return a condition that must hold if an effect changes anything, or true if none is found."""
    match effect:
        case m.WhenEffect(condition, part):
            return f.And((condition, _find_condition_needed_for_any_change(part, bound_names)))
        case m.ForAllEffect(variable, part) if variable.name not in bound_names:
            return f.Exists(
                variable, _find_condition_needed_for_any_change(part, bound_names | {variable.name})
            )
        case m.Delete(atom):
            return atom
        case _:
            return f.TRUE


def _ground_atom(atom: f.Atom, binding: Valuation) -> f.Atom:
    return f.Atom(atom.predicate, tuple(f.Constant(resolve_term(term, binding)) for term in atom.arguments))
