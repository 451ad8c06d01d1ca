"""Domains: complete declarations of worlds, and the simulators that execute actions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, TypeAlias

from eai.base.errors import DomainError, prefix_errors
from eai.logic.formula import FALSE, TRUE, Formula, Variable
from eai.world.action import Action, Fault
from eai.world.condition import ConditionCompiler
from eai.world.executable import CompiledOperator, FindArguments, applicability
from eai.world.fault import FaultKind
from eai.world.frame import UNBOUND, Frame
from eai.world.history import HistoryRule, conditions_held_before
from eai.world.operator import Operator
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary, require_tuple

FAULT_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
)
"""Order by which one kind of fault is chosen for a step that has several; the first kind wins."""


class Simulator(Protocol):
    """A world in which the actions of one episode are executed. Each episode begins a new simulator.

    The domain declares the predicates and the possible actions, and diagnoses impossible actions. The
    simulator gets neither impossible actions nor slips. Plans are searched, and exported, by the declaration
    alone.
    """

    @property
    def state(self) -> State:
        """The facts that hold now, as a state of the same episode as the initial state.

        `State.replace_facts` makes such a state.
        """

    def act(self, action: Action, declared: State) -> State | Fault:
        """Execute an action whose declared checks all hold.

        Args:
            action: the action.
            declared: the state that follows by the declared effects.

        Returns:
            The state after the action, in which its intended effects hold; or a fault if the action failed
            and changed nothing. The check of the fault need not be part of the declaration.
        """


BeginEpisode: TypeAlias = Callable[[State], Simulator]
"""Function that begins an episode of a simulator in a state. It may raise InputError.

Episodes that begin in equal states behave equally.
"""


class _DeclaredSimulator:
    """A world in which an action has exactly its declared effects."""

    def __init__(self, initial: State) -> None:
        self.state = initial

    def act(self, action: Action, declared: State) -> State | Fault:
        """Return the state that follows by the declared effects."""
        self.state = declared
        return declared


def begin_as_declared(initial: State) -> Simulator:
    """Begin an episode in which actions have exactly their declared effects."""
    return _DeclaredSimulator(initial)


@dataclass(frozen=True)
class Domain:
    """A declared world.

    Attributes:
        name: the domain's name on the command line.
        vocabulary: stored and derived predicates.
        operators: the actions.
        history_rule: function that tells a wrong order from a missing step.
        precedence: order by which one kind of fault is chosen for a step that has several; the first kind
            wins.
        visible: a formula about ``x``, its only free variable: the objects that an agent with a limited view
            sees. None if agents see everything.
        landmarks: a formula about ``x``: the objects that an agent with a limited view knows from the start
            without seeing them. None if there are no such objects.
        egocentric: relations that an agent with a limited view perceives only between itself and objects.
        begin: function that begins an episode; by default actions have exactly their declared effects.

    Raises:
        DomainError: two operators have one name, or a formula or effect uses an undeclared name. The whole
            declaration is compiled to find out.
    """

    name: str
    vocabulary: Vocabulary
    operators: tuple[Operator, ...]
    history_rule: HistoryRule = conditions_held_before
    precedence: tuple[FaultKind, ...] = FAULT_PRECEDENCE
    visible: Formula | None = None
    landmarks: Formula | None = None
    egocentric: tuple[Predicate, ...] = ()
    begin: BeginEpisode = begin_as_declared

    def __post_init__(self) -> None:
        require_tuple("operators", self.operators, Operator)
        names = [operator.name for operator in self.operators]
        for name in names:
            if names.count(name) > 1:
                raise DomainError(f"operator {name} is declared twice")
        for derived in self.vocabulary.derived:
            parameters = tuple([Variable(f"p{i}") for i in range(derived.arity)])
            with prefix_errors(f"derived predicate {derived.name}", DomainError):
                ConditionCompiler(self.vocabulary, Frame(parameters)).truth(derived(*parameters))
        with prefix_errors("visible", DomainError):
            _ = self.find_visible
        with prefix_errors("landmarks", DomainError):
            _ = self.find_landmarks
        _ = self.compiled

    @cached_property
    def arities(self) -> Mapping[str, int]:
        """The number of arguments of every operator, by name."""
        return {operator.name: operator.arity for operator in self.operators}

    @cached_property
    def compiled(self) -> Mapping[str, CompiledOperator]:
        """The compiled operators by name."""
        compiled: dict[str, CompiledOperator] = {}
        for operator in self.operators:
            with prefix_errors(f"operator {operator.name}", DomainError):
                compiled[operator.name] = CompiledOperator(operator, self.vocabulary)
        return compiled

    @cached_property
    def applicability(self) -> Mapping[str, FindArguments]:
        """Functions by operator name; each finds the arguments for which no check of the operator fails."""
        return {operator.name: applicability(operator, self.vocabulary) for operator in self.operators}

    def operator(self, name: str) -> Operator | None:
        """Return the operator of this name, or None."""
        compiled = self.compiled.get(name)
        return None if compiled is None else compiled.operator

    def apply(self, state: State, action: Action) -> State:
        """Return the state after a possible action. It does not check that the action is possible."""
        operator = self.compiled[action.operator]
        return operator.apply(state, operator.bind(state, action.arguments))

    def replace_operators(self, *changed: Operator, without: Sequence[str] = ()) -> Domain:
        """Return the domain after some operators were replaced by name, some added and some removed."""
        by_name = {operator.name: operator for operator in changed}
        operators = tuple(by_name.pop(o.name, o) for o in self.operators if o.name not in without)
        return replace(self, operators=(*operators, *by_name.values()))

    @cached_property
    def find_visible(self) -> Callable[[State, int], int]:
        """Function that selects, from a mask of objects, the objects that are visible in a state."""
        return self._compile_extension(self.visible or TRUE)

    @cached_property
    def find_landmarks(self) -> Callable[[State, int], int]:
        """Function that selects, from a mask of objects, the objects that the agent knows from the start."""
        return self._compile_extension(self.landmarks or FALSE)

    def _compile_extension(self, formula: Formula) -> Callable[[State, int], int]:
        """Compile a formula about ``x`` to a function that selects the objects that make it true."""
        frame = Frame((Variable("x"),))
        extension = ConditionCompiler(self.vocabulary, frame).extension(
            formula, frame.scope["x"], frame.scope
        )
        return lambda state, among: extension(state, frame.bind(state.scene, (UNBOUND,)), among)

    def holds(self, formula: Formula, state: State, arguments: Mapping[str, int] | None = None) -> bool:
        """Whether a state formula holds; ``arguments`` has the objects of its free variables."""
        arguments = arguments or {}
        frame = Frame(tuple(Variable(name) for name in arguments))
        truth = ConditionCompiler(self.vocabulary, frame).truth(formula)
        return truth(state, frame.bind(state.scene, tuple(arguments.values())))
