"""Execution of plans: the trajectory of a plan, and the diagnosis of the fault that ends the plan."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from eai.logic.formula import Atom, Variable
from eai.logic.trace import Trace
from eai.world.action import Action, Fault
from eai.world.condition import FormulaEvaluator
from eai.world.domain import Domain
from eai.world.executable import CompiledOperator
from eai.world.fault import FaultKind
from eai.world.frame import ObjectBySlot
from eai.world.history import History
from eai.world.operator import Check
from eai.world.state import Scene, State


class Step(NamedTuple):
    """An action that was tried. It was executed unless it has a fault or slipped (had no effect)."""

    action: Action
    fault: Fault | None
    slipped: bool = False

    @property
    def is_executed(self) -> bool:
        """Whether the action was executed."""
        return self.fault is None and not self.slipped


@dataclass(frozen=True, slots=True)
class Trajectory:
    """The states and steps of an executed plan, or of an episode.

    Attributes:
        states: the initial state, then the state after each executed step.
        steps: every step tried, in order. A fault ends a plan, and later steps are not tried. Only after
            the fault `ADDITIONAL_STEP` the plan goes on with the next step.
    """

    states: tuple[State, ...]
    steps: tuple[Step, ...]

    @property
    def final_state(self) -> State:
        """The last state of the trajectory."""
        return self.states[-1]

    @property
    def failure(self) -> Fault | None:
        """The fault of the last step, if this fault ended the plan; None if no fault ended the plan."""
        fault = self.steps[-1].fault if self.steps else None
        return None if fault is None or fault.kind is FaultKind.ADDITIONAL_STEP else fault

    @property
    def executed_actions(self) -> tuple[Action, ...]:
        """The actions that were executed."""
        return tuple(step.action for step in self.steps if step.is_executed)

    def prefix(self, executed: int) -> Trajectory:
        """Return the trajectory of only the first ``executed`` executed steps."""
        steps = [step for step in self.steps if step.is_executed][:executed]
        return Trajectory(self.states[: executed + 1], tuple(steps))

    @property
    def needless_step_count(self) -> int:
        """Number of steps that were skipped as additional, because they were not needed."""
        return sum([s.fault is not None and s.fault.kind is FaultKind.ADDITIONAL_STEP for s in self.steps])


def execute_plan(domain: Domain, initial: State, plan: Iterable[Action]) -> Trajectory:
    """Execute a plan up to its first step with a fault that ends the plan.

    Every action must name an operator of the domain, and have as many arguments as the operator has
    parameters.
    """
    history = History(initial)
    steps: list[Step] = []
    for action in plan:
        outcome = attempt_action(domain, history, action)
        if isinstance(outcome, State):
            history = history.extend(outcome)
            steps.append(Step(action, None))
            continue
        steps.append(Step(action, outcome))
        if outcome.kind is not FaultKind.ADDITIONAL_STEP:
            break
    return Trajectory(history.states, tuple(steps))


def attempt_action(domain: Domain, history: History, action: Action) -> State | Fault:
    """Try one action in the last state of a history. Return the state after the action, or the fault."""
    operator = domain.compiled_operators[action.operator]
    state = history.state
    binding = operator.bind(state, action.arguments)
    if operator.is_possible(state, binding):
        return operator.apply(state, binding)
    return _diagnose_fault(domain, history, operator, binding)


def _diagnose_fault(
    domain: Domain, history: History, operator: CompiledOperator, binding: ObjectBySlot
) -> Fault:
    """Return the fault of a step; of several faults, the first kind in `Domain.precedence`.

    For each failed check, `Domain.history_rule` searches for an earlier state in which the check's conditions
    held. If it finds a state, the steps were in a wrong order, so a wrong order is among the faults.
    """
    faults: dict[FaultKind, Fault] = {}
    for failure in operator.find_failures(history.state, binding):
        check = failure.check.check
        faults.setdefault(check.fault, Fault(check.fault, check))
        index = domain.history_rule(failure, binding, history)
        if index is not None:
            faults.setdefault(FaultKind.WRONG_ORDER, Fault(FaultKind.WRONG_ORDER, check, index))
    return faults[min(faults, key=domain.precedence.index)]


def describe_fault(fault: Fault, domain: Domain, action: Action, scene: Scene) -> str:
    """Return the text of a fault's reason, with the names of the action's objects."""
    return fault.check.reason.format_map(map_parameters_to_names(action, domain, scene))


def find_objects_explaining_failed_check(
    check: Check, domain: Domain, action: Action, state: State
) -> tuple[str, ...]:
    """Return the names of objects that show why a check failed, beyond the objects in the check's reason.

    ``state`` is the state in which the check failed.
    """
    if check.witness is None:
        return ()
    scope = map_parameters_to_object_indices(action, domain)
    indices = FormulaEvaluator(domain.vocabulary).find_witnesses(
        check.witness.variable, check.witness.body, scope, state
    )
    return tuple([state.scene.objects[i].name for i in indices])


def map_parameters_to_names(action: Action, domain: Domain, scene: Scene) -> dict[str, str]:
    """Return a mapping from the names of an action's parameters to the names of its objects."""
    return {
        name: scene.objects[index].name
        for name, index in map_parameters_to_object_indices(action, domain).items()
    }


def map_parameters_to_object_indices(action: Action, domain: Domain) -> dict[str, int]:
    """Return a mapping from the names of an action's parameters to the indices of its objects."""
    return domain.compiled_operators[action.operator].operator.map_parameters(action.arguments)


def to_trace(trajectory: Trajectory) -> Trace:
    """Convert a trajectory to a trace, on which temporal formulas with names of objects are evaluated."""
    scene = trajectory.states[0].scene
    readings, atoms = FormulaEvaluator(scene.vocabulary), dict[str, Atom]()
    actions = [
        (a.operator, tuple([scene.objects[i].name for i in a.arguments])) for a in trajectory.executed_actions
    ]
    return Trace([_StateWithObjectNames(state, readings, atoms) for state in trajectory.states], actions)


class _StateWithObjectNames:
    """A state whose objects are given by name, for the evaluation of formulas.

    All states of a trajectory share one atom for each derived predicate, so that it is compiled only once.
    """

    __slots__ = ("_atoms", "_readings", "_state")

    def __init__(self, state: State, readings: FormulaEvaluator, atoms: dict[str, Atom]) -> None:
        self._state, self._readings, self._atoms = state, readings, atoms

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        index, vocabulary = self._state.scene.index, self._state.scene.vocabulary
        if vocabulary.find_arity(predicate) != len(arguments) or any(name not in index for name in arguments):
            return False
        indices = [index[name] for name in arguments]
        if vocabulary.find_stored_predicate(predicate) is not None:
            return self._state.has(predicate, *indices)
        names = [f"argument {i}" for i in range(len(indices))]
        if predicate not in self._atoms:
            self._atoms[predicate] = Atom(predicate, tuple([Variable(name) for name in names]))
        scope = dict(zip(names, indices, strict=True))
        return self._readings.holds(self._atoms[predicate], scope, self._state)

    def list_objects(self, category: str | None) -> Sequence[str]:
        return self._state.scene.names_of_category(category)
