"""Domains: complete declarations of worlds, and the simulators that execute actions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, TypeAlias

from eai.base.errors import DomainError, prefix_errors_with_location
from eai.logic.formula import FALSE, TRUE, Formula, Variable
from eai.world.action import Action, Fault
from eai.world.condition import ConditionCompiler
from eai.world.executable import ApplicableArgumentFinder, CompiledOperator, compile_argument_finder
from eai.world.fault import FAULT_PRECEDENCE, FaultKind
from eai.world.frame import UNBOUND, SlotAllocator
from eai.world.history import HistoryRule, find_when_conditions_held
from eai.world.operator import Operator
from eai.world.relation import ObjectMask
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary, require_tuple


class Simulator(Protocol):
    """A world in which the actions of one episode are executed. Each episode has a simulator of its own.

    The domain, not the simulator, declares the predicates and the possible actions, and diagnoses impossible
    actions. The simulator gets neither impossible actions nor slips (possible actions that by chance have
    no effect). Plans are searched and exported by the domain's declaration only.
    """

    @property
    def state(self) -> State:
        """The current state, which belongs to the same episode as the initial state.

        A simulator makes it by `State.replace_all_facts`.
        """

    def act(self, action: Action, state_after_declared_effects: State) -> State | Fault:
        """Execute an action whose declared checks all hold.

        Args:
            action: the action.
            state_after_declared_effects: the state that the declared effects lead to.

        Returns:
            The state after the action, or a fault if the action failed and changed nothing. In the state, the
            visible effects that the domain declares without a condition must hold. The failed check of the
            fault may be one that the domain does not declare.
        """


BeginEpisode: TypeAlias = Callable[[State], Simulator]
"""Function that begins an episode: it takes the initial state and returns a new simulator.

It may raise InputError. Episodes that begin in equal states behave equally.
"""


class _DeclaredEffectsSimulator:
    """A simulator in which an action has exactly its declared effects."""

    def __init__(self, initial: State) -> None:
        self.state = initial

    def act(self, action: Action, state_after_declared_effects: State) -> State | Fault:
        """Return the state that the declared effects lead to."""
        self.state = state_after_declared_effects
        return state_after_declared_effects


def make_declared_effects_simulator(initial: State) -> Simulator:
    """Return a simulator in which actions have exactly their declared effects."""
    return _DeclaredEffectsSimulator(initial)


@dataclass(frozen=True)
class Domain:
    """A declaration of a world: its predicates, its actions, and how an agent perceives it.

    Attributes:
        name: the domain's name on the command line.
        vocabulary: stored and derived predicates.
        operators: the actions.
        history_rule: function that tests whether a failed check is a wrong order or a missing step.
        precedence: order of kinds of fault: if a step has several faults, the kind that comes first is
            reported.
        visible: a formula with ``x`` as its only free variable. It holds for the objects that an agent with a
            limited view sees. None if agents see everything.
        landmarks: a formula about ``x``. It holds for the objects that an agent with a limited view knows
            from the start without seeing them. None if there are no such objects.
        egocentric: relations that an agent with a limited view perceives only between itself and objects.
        begin: function that begins an episode; by default actions have exactly their declared effects.

    Raises:
        DomainError: two operators have the same name, or a formula or effect uses an undeclared name. To
            check this, the whole declaration is compiled.
    """

    name: str
    vocabulary: Vocabulary
    operators: tuple[Operator, ...]
    history_rule: HistoryRule = find_when_conditions_held
    precedence: tuple[FaultKind, ...] = FAULT_PRECEDENCE
    visible: Formula | None = None
    landmarks: Formula | None = None
    egocentric: tuple[Predicate, ...] = ()
    begin: BeginEpisode = make_declared_effects_simulator

    def __post_init__(self) -> None:
        require_tuple("operators", self.operators, Operator)
        names = [operator.name for operator in self.operators]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(f"operator {name} is declared twice: give each operator a name of its own")
        for derived in self.vocabulary.derived:
            parameters = tuple([Variable(f"p{i}") for i in range(derived.arity)])
            with prefix_errors_with_location(f"derived predicate {derived.name}", DomainError):
                ConditionCompiler(self.vocabulary, SlotAllocator(parameters)).compile_test(
                    derived(*parameters)
                )
        with prefix_errors_with_location("visible", DomainError):
            _ = self.visible_object_filter
        with prefix_errors_with_location("landmarks", DomainError):
            _ = self.initially_known_object_filter
        _ = self.compiled_operators

    @cached_property
    def operator_arities(self) -> Mapping[str, int]:
        """Mapping from the name of each operator to its number of arguments."""
        return {operator.name: operator.arity for operator in self.operators}

    @cached_property
    def compiled_operators(self) -> Mapping[str, CompiledOperator]:
        """Mapping from the name of each operator to the compiled operator."""
        compiled: dict[str, CompiledOperator] = {}
        for operator in self.operators:
            with prefix_errors_with_location(f"operator {operator.name}", DomainError):
                compiled[operator.name] = CompiledOperator(operator, self.vocabulary)
        return compiled

    @cached_property
    def argument_finder_by_operator(self) -> Mapping[str, ApplicableArgumentFinder]:
        """Mapping from the name of each operator to a function that finds its applicable arguments.

        No check of the operator fails for these arguments.
        """
        return {
            operator.name: compile_argument_finder(operator, self.vocabulary) for operator in self.operators
        }

    def find_operator(self, name: str) -> Operator | None:
        """Return the operator with this name, or None if there is no such operator."""
        compiled = self.compiled_operators.get(name)
        return None if compiled is None else compiled.operator

    def apply(self, state: State, action: Action) -> State:
        """Return the state after an action, unchecked. For an impossible action, the state means nothing."""
        operator = self.compiled_operators[action.operator]
        return operator.apply(state, operator.bind(state, action.arguments))

    def replace_operators(self, *changed: Operator, without: Sequence[str] = ()) -> Domain:
        """Return a copy of the domain with some operators replaced by name, some added and some removed."""
        by_name = {operator.name: operator for operator in changed}
        operators = tuple(by_name.pop(o.name, o) for o in self.operators if o.name not in without)
        return replace(self, operators=(*operators, *by_name.values()))

    @cached_property
    def visible_object_filter(self) -> Callable[[State, ObjectMask], ObjectMask]:
        """Function that takes a state and a bit mask of objects, and returns the mask of visible objects."""
        return self._compile_filter(self.visible or TRUE)

    @cached_property
    def initially_known_object_filter(self) -> Callable[[State, ObjectMask], ObjectMask]:
        """Function that takes a state and a mask of objects, and returns the landmarks among them.

        Landmarks are objects that the agent knows from the start without seeing them.
        """
        return self._compile_filter(self.landmarks or FALSE)

    def _compile_filter(self, formula: Formula) -> Callable[[State, ObjectMask], ObjectMask]:
        """Compile a formula about ``x`` to a function that selects the objects that make it true."""
        frame = SlotAllocator((Variable("x"),))
        object_filter = ConditionCompiler(self.vocabulary, frame).compile_filter(
            formula, frame.scope["x"], frame.scope
        )
        return lambda state, among: object_filter(state, frame.bind_arguments(state.scene, (UNBOUND,)), among)

    def holds(self, formula: Formula, state: State, arguments: Mapping[str, int] | None = None) -> bool:
        """Whether a formula holds in a state; ``arguments`` maps its free variables to object indices."""
        arguments = arguments or {}
        frame = SlotAllocator(tuple(Variable(name) for name in arguments))
        truth = ConditionCompiler(self.vocabulary, frame).compile_test(formula)
        return truth(state, frame.bind_arguments(state.scene, tuple(arguments.values())))
