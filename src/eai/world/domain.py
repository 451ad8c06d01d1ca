"""Domains: everything there is to know about a world, declared in one value, and who carries actions out."""

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
"""Which kind of fault counts where a step has several, first to last."""


class Simulator(Protocol):
    """A world in which actions are carried out, begun anew for each episode.

    Its domain says what can be told of it and which actions are possible, and diagnoses those that are not:
    these never get here. Slips do not either. What plans are searched with, and exported, is the declaration.
    """

    @property
    def state(self) -> State:
        """The facts that hold now: a state of the same episode as that in which it began.

        `State.with_exactly` makes one of facts.
        """

    def act(self, action: Action, declared: State) -> State | Fault:
        """Carry out an action that is possible by its declaration.

        Args:
            action: the action.
            declared: the state that follows by the declared effects.

        Returns:
            The state after it, in which its intended effects hold; or why it failed, and then nothing has
            changed. The check of a fault need not be one of the declaration.
        """


BeginEpisode: TypeAlias = Callable[[State], Simulator]
"""Begins an episode in a state: equal states make equal worlds. It raises InputError where it cannot."""


class _Declared:
    """The world as it is declared: an action has the effects that its operator has."""

    def __init__(self, initial: State) -> None:
        self.state = initial

    def act(self, action: Action, declared: State) -> State | Fault:
        """Take the declared state."""
        self.state = declared
        return declared


def begin_as_declared(initial: State) -> Simulator:
    """Begin an episode in which actions have their declared effects, and no others."""
    return _Declared(initial)


@dataclass(frozen=True)
class Domain:
    """A declared world.

    Attributes:
        name: the domain's name, as the command line takes it.
        vocabulary: stored and derived predicates.
        operators: the actions.
        history_rule: tells a wrong order from a missing step.
        precedence: which kind of fault counts where a step has several, first to last.
        visible: what an agent sees that does not see everything: the objects that make this true as ``x``,
            its only free variable. None where whoever acts sees all there is.
        landmarks: what such an agent knows of from the start without seeing it: the objects that make this
            true as ``x``. None where there is nothing.
        egocentric: the relations that such an agent perceives of itself alone, not between other things.
        begin: begins the world of an episode; by default one in which actions have their declared effects.

    Raises:
        DomainError: two operators have one name, or a formula or effect uses what is not declared. All of
            the declaration is compiled to find out.
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
        """The operators by name, ready to run."""
        compiled: dict[str, CompiledOperator] = {}
        for operator in self.operators:
            with prefix_errors(f"operator {operator.name}", DomainError):
                compiled[operator.name] = CompiledOperator(operator, self.vocabulary)
        return compiled

    @cached_property
    def applicability(self) -> Mapping[str, FindArguments]:
        """With which objects no check of an operator fails, by its name."""
        return {operator.name: applicability(operator, self.vocabulary) for operator in self.operators}

    def operator(self, name: str) -> Operator | None:
        """The operator of this name, or None."""
        compiled = self.compiled.get(name)
        return None if compiled is None else compiled.operator

    def apply(self, state: State, action: Action) -> State:
        """The state after an action that is possible, without diagnosis; of others nothing is promised."""
        operator = self.compiled[action.operator]
        return operator.apply(state, operator.bind(state, action.arguments))

    def replace_operators(self, *changed: Operator, without: Sequence[str] = ()) -> Domain:
        """The domain in which these operators replace those of their name, and some are left out."""
        by_name = {operator.name: operator for operator in changed}
        kept = tuple(by_name.pop(o.name, o) for o in self.operators if o.name not in without)
        return replace(self, operators=(*kept, *by_name.values()))

    @cached_property
    def find_visible(self) -> Callable[[State, int], int]:
        """The visible ones among some objects in a state, both as masks."""
        return self._among(self.visible or TRUE)

    @cached_property
    def find_landmarks(self) -> Callable[[State, int], int]:
        """The ones among some objects that are known of from the start, which is a state; both as masks."""
        return self._among(self.landmarks or FALSE)

    def _among(self, formula: Formula) -> Callable[[State, int], int]:
        """Of some objects those that make a formula about ``x`` true in a state; both as masks."""
        frame = Frame((Variable("x"),))
        found = ConditionCompiler(self.vocabulary, frame).extension(formula, frame.scope["x"], frame.scope)
        return lambda state, among: found(state, frame.bind(state.scene, (UNBOUND,)), among)

    def holds(self, formula: Formula, state: State, arguments: Mapping[str, int] | None = None) -> bool:
        """Whether a state formula holds; ``arguments`` gives its free variables their objects."""
        arguments = arguments or {}
        frame = Frame(tuple(Variable(name) for name in arguments))
        truth = ConditionCompiler(self.vocabulary, frame).truth(formula)
        return truth(state, frame.bind(state.scene, tuple(arguments.values())))
