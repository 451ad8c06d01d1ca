"""Ground operators with objects; conditions and effects become bit masks over numbered atoms.

Grounding replaces atoms that no effect can change by their truth: true atoms of predicates that are never
deleted, and false atoms of predicates that are never added. A state is an integer whose bit i says whether
atom i is true.

A set of literals is a bit mask, too. With n atoms, bit i says that atom i may be true, and bit n + i that it
may be false. A state has one of these two bits for each atom; a relaxed state (`relaxation`) may have both.
Each disjunction of conditions has a literal of its own, which is present if all literals of one disjunct are
present. Equal disjunctions share one literal. So any condition is the mask of the literals that it needs.
Many conditions are tested at once, and all possible actions of a state are found at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import find_free_variables, find_object_names
from eai.pddl.execute import DerivedPredicates, PlanStep
from eai.planning.search import SearchEffort

LiteralMask: TypeAlias = int
"""Set of literals, as a bit mask."""

StateMask: TypeAlias = int
"""State, as the bit mask of its true atoms."""


class _GroundCondition(NamedTuple):
    """A ground condition: atoms that must be true, atoms that must be false, and disjunctions of conditions.

    ``true`` and ``false`` are bit masks. Each of ``choices`` is a disjunction.
    """

    true: int
    false: int
    choices: tuple[tuple[_GroundCondition, ...], ...]


class _GroundEffect(NamedTuple):
    """A ground conditional effect; ``add`` and ``delete`` are bit masks of atoms."""

    condition: _GroundCondition
    add: int
    delete: int


class _GroundAction(NamedTuple):
    """An operator with objects for its parameters.

    Its unconditional effects are combined into the first effect.
    """

    step: PlanStep
    precondition: _GroundCondition
    effects: tuple[_GroundEffect, ...]


_ALWAYS = _GroundCondition(0, 0, ())

_LOOKS_PER_SUCCESSOR = 10
"""Cost of making one successor, in looks. A look is one test of an object or literal (`SearchEffort`)."""

_Key = tuple[str, ...]
_Binding = Mapping[str, str]


class Grounder:
    """Grounds one domain and problem. Atoms are numbered in the order of their first use.

    Args:
        domain: the operators.
        problem: the objects, the initial state and the goal.
        looks: the budget: the number of objects tried as values of parameters and quantified variables;
            unlimited by default. If the budget is exceeded, the result is incomplete.
    """

    def __init__(
        self, domain: m.PddlDomain, problem: m.PddlProblem, looks: SearchEffort | None = None
    ) -> None:
        self._looks = looks or SearchEffort()
        self._domain = domain
        self._problem = problem
        self._objects = m.group_objects_by_type(domain, problem)
        self._facts = {_make_atom_key(atom, {}) for atom in problem.initial}
        effects = [part for action in domain.actions for part, _ in m.split_effect(action.effect)]
        self._added = {part.atom.predicate for part in effects if isinstance(part, m.Add)}
        self._deleted = {part.atom.predicate for part in effects if isinstance(part, m.Delete)}
        self._axioms = DerivedPredicates(domain.axioms).axioms
        self.numbers: dict[_Key, int] = {}
        self._ground: dict[tuple[object, ...], _GroundAction | None] = {}

    @property
    def initial_atoms_mask(self) -> StateMask:
        """The initial state as a bit mask over the numbered atoms; complete only after grounding."""
        return sum(1 << number for key, number in self.numbers.items() if key in self._facts)

    @property
    def problem_objects(self) -> frozenset[str]:
        """The names of all objects of the problem."""
        return frozenset(self._objects["object"])

    def goal(self) -> _GroundCondition | None:
        """Return the ground goal, or None if it is false in every state."""
        return self._ground_condition(self._problem.goal, {}, negated=False)

    def generate_actions(self, allowed_objects: frozenset[str] | None = None) -> Iterator[_GroundAction]:
        """Yield all ground actions that may be possible in some state and that change something.

        Args:
            allowed_objects: the objects that parameters may take; None for all. Quantifiers always range over
                all objects.
        """
        for number, action in enumerate(self._domain.actions):
            for binding in self._generate_bindings(action, allowed_objects):
                key = (number, *binding.values())
                if key not in self._ground:
                    self._ground[key] = self._ground_action(action, binding)
                ground = self._ground[key]
                if ground is not None:
                    yield ground

    def find_objects_of_goal_and_parameter_types(self) -> frozenset[str]:
        """Return the objects that the goal names, and the objects of the types of operators' parameters.

        A parameter type is ignored if all objects belong to the type.
        """
        named = {*find_object_names(self._problem.goal)}
        asked = {
            m.get_variable_type(parameter)
            for action in self._domain.actions
            for parameter in action.parameters
        }
        for members in (self._objects[name] for name in asked):
            if self.problem_objects != set(members):
                named.update(members)
        return frozenset(named)

    def _generate_bindings(
        self, action: m.PddlAction, allowed_objects: frozenset[str] | None
    ) -> Iterator[dict[str, str]]:
        """Return the bindings of parameters that satisfy the static conjuncts of an operator's precondition.

        A parameter that occurs in no condition and no effect takes only one object, because every object
        gives an equal action.
        """
        tests = self._group_static_atoms_by_last_parameter(action)
        mentioned = find_free_variables(action.precondition) | m.find_effect_variables(action.effect)
        stack: list[dict[str, str]] = [{}]
        for parameter in action.parameters:
            members = self._objects[m.get_variable_type(parameter)]
            candidates = [name for name in members if allowed_objects is None or name in allowed_objects]
            stack = [
                extended
                for binding in stack
                for name in self._looks.yield_objects_until_effort_limit(
                    candidates if parameter.name in mentioned else candidates[:1]
                )
                if self._are_initial_facts(
                    tests[parameter.name], extended := {**binding, parameter.name: name}
                )
            ]
        return iter(stack)

    def _group_static_atoms_by_last_parameter(self, action: m.PddlAction) -> dict[str, list[f.Atom]]:
        """Return, for each parameter, the static atoms to test as soon as the parameter has an object."""
        tests: dict[str, list[f.Atom]] = {parameter.name: [] for parameter in action.parameters}
        order, may_become_true = list(tests), self._added.union(self._axioms)
        for part in f.get_operands(action.precondition, f.And):
            if isinstance(part, f.Atom) and part.predicate not in may_become_true:
                places = [order.index(term.name) for term in part.arguments if isinstance(term, f.Variable)]
                if places:
                    tests[order[max(places)]].append(part)
        return tests

    def _are_initial_facts(self, atoms: Sequence[f.Atom], binding: _Binding) -> bool:
        return all(_make_atom_key(atom, binding) in self._facts for atom in atoms)

    def _ground_action(self, action: m.PddlAction, binding: _Binding) -> _GroundAction | None:
        precondition = self._ground_condition(action.precondition, binding, negated=False)
        if precondition is None:
            return None
        effects: list[_GroundEffect] = []
        self._add_ground_effects(action.effect, binding, _ALWAYS, effects)
        add = delete = 0
        conditional = []
        for change in effects:
            if change.condition is _ALWAYS:
                add |= change.add
                delete |= change.delete
            elif change.add or change.delete:
                conditional.append(change)
        changes = [_GroundEffect(_ALWAYS, add, delete)] if add or delete else []
        changes += conditional
        arguments = tuple(binding[parameter.name] for parameter in action.parameters)
        if changes:
            return _GroundAction(PlanStep(action.name, arguments), precondition, tuple(changes))
        return None

    def _add_ground_effects(
        self, effect: m.PddlEffect, binding: _Binding, condition: _GroundCondition, found: list[_GroundEffect]
    ) -> None:
        """Append to a list the ground effects of an effect that takes place under a condition."""
        match effect:
            case m.Add(atom):
                found.append(_GroundEffect(condition, self._get_atom_bit(_make_atom_key(atom, binding)), 0))
            case m.Delete(atom):
                found.append(_GroundEffect(condition, 0, self._get_atom_bit(_make_atom_key(atom, binding))))
            case m.AndEffect(parts):
                for part in parts:
                    self._add_ground_effects(part, binding, condition, found)
            case m.ForAllEffect(variable, part):
                for inner in self._bind_to_each_object(variable, binding):
                    self._add_ground_effects(part, inner, condition, found)
            case m.WhenEffect(premise, part):
                combined = _conjoin_conditions(
                    (condition, self._ground_condition(premise, binding, negated=False))
                )
                if combined is not None:
                    self._add_ground_effects(part, binding, combined, found)

    def _ground_condition(
        self, formula: f.Formula, binding: _Binding, *, negated: bool
    ) -> _GroundCondition | None:
        """Return the ground condition, or None if it is false in every state."""
        match formula:
            case f.Atom():
                return self._ground_literal(formula, binding, negated=negated)
            case f.Equals(left, right):
                if (_find_object_name(left, binding) == _find_object_name(right, binding)) != negated:
                    return _ALWAYS
                return None
            case f.Not(operand):
                return self._ground_condition(operand, binding, negated=not negated)
            case f.And(operands) | f.Or(operands):
                parts = (self._ground_condition(operand, binding, negated=negated) for operand in operands)
                if isinstance(formula, f.And) != negated:
                    return _conjoin_conditions(parts)
                return _disjoin_conditions(parts)
            case f.Implies(premise, conclusion):
                return self._ground_condition(f.Or((f.Not(premise), conclusion)), binding, negated=negated)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                inners = self._bind_to_each_object(variable, binding)
                parts = (self._ground_condition(body, inner, negated=negated) for inner in inners)
                if isinstance(formula, f.ForAll) != negated:
                    return _conjoin_conditions(parts)
                return _disjoin_conditions(parts)
            case _:
                raise ValueError(
                    f"{type(formula).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
                )

    def _ground_literal(self, atom: f.Atom, binding: _Binding, *, negated: bool) -> _GroundCondition | None:
        if atom.predicate in self._axioms:
            return self._ground_derived(atom, binding, negated=negated)
        key = _make_atom_key(atom, binding)
        bit = self._get_atom_bit(key)
        if not bit:
            return _ALWAYS if (key in self._facts) != negated else None
        return _GroundCondition(0, bit, ()) if negated else _GroundCondition(bit, 0, ())

    def _ground_derived(self, atom: f.Atom, binding: _Binding, *, negated: bool) -> _GroundCondition | None:
        """Return the ground condition of a derived predicate; recursive predicates are not supported."""
        names = [_find_object_name(term, binding) for term in atom.arguments]
        axioms = self._axioms[atom.predicate]
        parts = (
            self._ground_condition(axiom.condition, axiom.map_parameters(names), negated=negated)
            for axiom in axioms
        )
        return _conjoin_conditions(parts) if negated else _disjoin_conditions(parts)

    def _get_atom_bit(self, key: _Key) -> int:
        """Return the bit of an atom as a mask, or 0 if no effect can change the atom."""
        if key[0] not in (self._deleted if key in self._facts else self._added):
            return 0
        return 1 << self.numbers.setdefault(key, len(self.numbers))

    def _bind_to_each_object(self, variable: f.Variable, binding: _Binding) -> Iterator[_Binding]:
        """Yield a binding for each object of a variable.

        Every binding is the same dictionary, changed in place. So the caller must use a binding before the
        next.
        """
        inner, slot = {**binding}, variable.name
        for inner[slot] in self._looks.yield_objects_until_effort_limit(
            self._objects[m.get_variable_type(variable)]
        ):
            yield inner


def _conjoin_conditions(parts: Iterable[_GroundCondition | None]) -> _GroundCondition | None:
    true = false = 0
    choices: list[tuple[_GroundCondition, ...]] = []
    for part in parts:
        if part is None:
            return None
        true |= part.true
        false |= part.false
        choices += part.choices
    if true & false:
        return None
    return _GroundCondition(true, false, tuple(choices)) if true or false or choices else _ALWAYS


def _disjoin_conditions(parts: Iterable[_GroundCondition | None]) -> _GroundCondition | None:
    options: list[_GroundCondition] = []
    for part in parts:
        if part is _ALWAYS:
            return _ALWAYS
        if part is not None:
            options.append(part)
    if len(options) < 2:
        return options[0] if options else None
    return _GroundCondition(0, 0, (tuple(options),))


def _make_atom_key(atom: f.Atom, binding: _Binding) -> _Key:
    names = [binding[t.name] if isinstance(t, f.Variable) else t.name for t in atom.arguments]
    return (atom.predicate, *names)


def _find_object_name(term: f.Term, binding: _Binding) -> str:
    return binding[term.name] if isinstance(term, f.Variable) else term.name


class _GroundDisjunction(NamedTuple):
    """A disjunction of conditions: the literal that stands for it, and the disjuncts as masks of literals.

    Disjuncts with one literal are also given as one mask (``simple``), and longer disjuncts as a tuple
    (``compound``).
    """

    literal: int
    options: tuple[int, ...]
    simple: int
    compound: tuple[int, ...]


class _EffectMasks(NamedTuple):
    """A conditional effect as bit masks of needed literals, added atoms and deleted atoms."""

    needs: int
    add: int
    delete: int


class _ActionAsLiteralMasks(NamedTuple):
    """A ground action: the bit mask of the literals that it needs, and its effects.

    Its unconditional effects are combined into the first effect, which needs no literals.
    """

    step: PlanStep
    needs: int
    changes: Sequence[_EffectMasks]


class GroundProblem:
    """A grounded problem: its literals, the literals of its goal, and the successors of its states.

    Args:
        grounder: the grounder of the actions and the goal.
        actions: the ground actions, numbered in order.
        goal: the ground goal.
        looks: the budget: the number of literals, disjuncts, conditions and effects that may be tested.

    Attributes:
        atoms: number of atoms, n. A mask of literals has n bits for true atoms, n bits for false atoms,
            n bits that only `Relaxation` uses, and a bit for each disjunction, in this order.
        initial: the initial state.
        goal: the literals that the goal needs.
        actions: the ground actions.
    """

    def __init__(
        self,
        grounder: Grounder,
        actions: Iterable[_GroundAction],
        goal: _GroundCondition,
        looks: SearchEffort,
    ) -> None:
        self.atoms = len(grounder.numbers)
        self.initial = grounder.initial_atoms_mask
        self._looks = looks
        self._every_atom = (1 << self.atoms) - 1
        self._choices: dict[tuple[int, ...], _GroundDisjunction] = {}
        self._effort = 0
        self.goal = self._find_needed_literals(goal)
        self.actions = [self._compile_action(action) for action in actions]
        self._every_action = (1 << len(self.actions)) - 1
        self._needing = map_bits_to_indices_of_containing_masks([action.needs for action in self.actions])
        self._price = estimate_cost_of_condition_lookup(len(self.actions)) * len(self._needing)

    def _compile_action(self, action: _GroundAction) -> _ActionAsLiteralMasks:
        needs = self._find_needed_literals(action.precondition)
        changes = [
            _EffectMasks(self._find_needed_literals(when), add, delete)
            for when, add, delete in action.effects
        ]
        return _ActionAsLiteralMasks(action.step, needs, changes)

    def _find_needed_literals(self, condition: _GroundCondition) -> LiteralMask:
        """Return the literals that a condition needs, as a bit mask."""
        needed = condition.true | condition.false << self.atoms
        for options in condition.choices:
            needed |= self._get_or_make_ground_disjunction(
                tuple([self._find_needed_literals(option) for option in options])
            ).literal
        return needed

    def _get_or_make_ground_disjunction(self, disjuncts: tuple[int, ...]) -> _GroundDisjunction:
        choice = self._choices.get(disjuncts)
        if choice is None:
            literal = 1 << 3 * self.atoms + len(self._choices)
            compound = tuple([option for option in disjuncts if option & option - 1])
            simple = sum({*disjuncts}.difference(compound))
            choice = self._choices[disjuncts] = _GroundDisjunction(literal, disjuncts, simple, compound)
            self._effort += 1 + len(compound)
        return choice

    def find_state_literals(self, state: StateMask) -> LiteralMask:
        """Return the literals and disjunctions that are true in a state, as a bit mask."""
        return self.add_literals_of_true_disjunctions(state | (~state & self._every_atom) << self.atoms)

    def add_literals_of_true_disjunctions(self, literals: LiteralMask) -> LiteralMask:
        """Return literals, and the literals that stand for the disjunctions that these literals make true."""
        self._looks.used += self._effort
        choices = self._choices.values()  # inner disjunctions were created first, so they become true first
        for literal, _, simple, compound in choices:
            if not literals & literal and (
                simple & literals or any(not option & ~literals for option in compound)
            ):
                literals |= literal
        return literals

    def replace_disjunctions_by_true_disjuncts(
        self, needed: LiteralMask, true_literals: LiteralMask
    ) -> LiteralMask:
        """Return needed literals with all disjunctions among them replaced.

        Each disjunction becomes its first disjunct whose literals are all in ``true_literals``.
        """
        if needed >> 3 * self.atoms:
            for literal, options, _, _ in reversed(self._choices.values()):
                if needed & literal:
                    needed ^= literal
                    needed |= next(option for option in options if not option & ~true_literals)
        return needed

    def add_disjuncts_of_needed_disjunctions(self, needed: LiteralMask) -> LiteralMask:
        """Return the needed literals and, for each literal that stands for a disjunction, its disjuncts."""
        for literal, options, _, _ in reversed(self._choices.values()):
            if needed & literal:
                for option in options:
                    needed |= option
        return needed

    def generate_successors(self, state: StateMask, literals: LiteralMask) -> Iterator[tuple[int, StateMask]]:
        """Yield a pair for each action that is possible in a state with these literals, in order of actions.

        A pair is a bit mask in which only the bit of the action is set, and the state after the action.
        """
        possible = self._every_action
        for literal, needing in self._needing.items():
            if not literals & literal:
                possible &= ~needing
        self._looks.used += self._price + _LOOKS_PER_SUCCESSOR * possible.bit_count()
        for action in iterate_one_bit_masks(possible):
            yield action, self.apply_action(action.bit_length() - 1, state, literals)

    def apply_action(self, action_number: int, state: StateMask, true_literals: LiteralMask) -> StateMask:
        """Return the state after the action with the given number, even if the action is impossible."""
        add = delete = 0
        for needs, also_add, also_delete in self.actions[action_number].changes:
            if not needs & ~true_literals:
                add |= also_add
                delete |= also_delete
        return state & ~delete | add  # an atom that is both deleted and added is true


def estimate_cost_of_condition_lookup(condition_count: int) -> int:
    """Return the cost in looks of finding all conditions that need a given literal, by their number."""
    return 1 + condition_count // 2_000


_OneBitMask: TypeAlias = int
"""Mask in which one bit is set."""

_IndexMask: TypeAlias = int
"""Set of indices of a sequence, as a bit mask."""


def map_bits_to_indices_of_containing_masks(masks: Iterable[LiteralMask]) -> Mapping[_OneBitMask, _IndexMask]:
    """Return a mapping from each bit to the indices of the masks that contain it."""
    numbers: dict[int, list[int]] = {}
    for number, mask in enumerate(masks):
        for bit in iterate_one_bit_masks(mask):
            numbers.setdefault(bit, []).append(number)
    return {bit: _make_mask(mask_numbers) for bit, mask_numbers in numbers.items()}


def _make_mask(numbers: Sequence[int]) -> int:
    """Return ascending numbers as a bit mask."""
    octets = bytearray(numbers[-1] // 8 + 1)
    for number in numbers:
        octets[number >> 3] |= 1 << (number & 7)
    return int.from_bytes(octets, "little")


def iterate_one_bit_masks(mask: int) -> Iterator[int]:
    """Yield each set bit of a mask as a mask with only this bit, in ascending order."""
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit
