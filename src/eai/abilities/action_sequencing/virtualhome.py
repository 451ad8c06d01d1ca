"""Action sequencing in VirtualHome: from an answer's text to a verdict."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from eai.abilities.action_sequencing import virtualhome_answer
from eai.abilities.action_sequencing.goals import TaskGoals
from eai.abilities.action_sequencing.plan import (
    Rejected,
    Unreadable,
    WrittenPlan,
    WrittenStep,
    rejection_explained,
)
from eai.abilities.explanation import Explanation, goal_reports, repairs_told, step_reports
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task import Task
from eai.abilities.verdict import ErrorReport, Verdict
from eai.benchmarks.reference import virtualhome_plans as virtualhome_reference
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.world.domain import Domain
from eai.world.execution import Action, Trajectory, describe, execute
from eai.world.fault import FaultKind

NOT_ACCEPTED_BY_REFERENCE = ("PLUGIN", "PLUGOUT", "RELEASE")
"""Actions that the reference's prompt offers and its vocabulary test rejects (``valid_actions``)."""

NO_GOALS = "the task has no goals"
GOLD_TEST = "the data set's own final state fails the reference's goal test"


class ActionSequencing(Scorer):
    """The scorer of one task under one protocol.

    Under `eai-1.0.5` tasks whose own annotation fails the goal test are excluded, under `strict` those that
    have no goal.

    Args:
        task: the task.
        protocol: the rules.
        with_ids: whether objects are written as name and id (release 1.0.5) or as name only (the paper's
            responses); None looks at each answer itself.
    """

    def __init__(self, task: Task, protocol: Protocol, *, with_ids: bool | None = None) -> None:
        self.task = task
        self.protocol = protocol
        self._with_ids = with_ids
        self.domain = domain_of(protocol)
        self._goals = TaskGoals(task, protocol)
        self._names = _Names(task, protocol)
        self._excluded = self._reason_to_exclude()

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer; its explanation executes also what the verdict leaves out."""
        if self._excluded is not None:
            return Assessment(Verdict(excluded=self._excluded), lambda: self._assess(text).explain())
        return self._assess(text)

    def _assess(self, text: str) -> Assessment:
        """The assessment as if the task were not excluded."""
        plan = self.read(text)
        if isinstance(plan, Unreadable):
            return Assessment(self._unread(plan), partial(Explanation, (f"parsing: {plan.reason}",)))
        actions = self.resolve(plan)
        if isinstance(actions, Rejected):
            verdict = self._rejection(actions.error, plan.repairs)
            return Assessment(verdict, partial(rejection_explained, self._notes(plan), actions.error))
        trajectory = execute(self.domain, self.task.initial, actions)
        equals_script = self._equals_script(actions)
        return Assessment(
            replace(self._rejection(None, plan.repairs), executable=True)
            if equals_script
            else self._judge(trajectory, plan.repairs),
            partial(self._explain, plan, trajectory, equals_script=equals_script),
        )

    def _explain(self, plan: WrittenPlan, trajectory: Trajectory, *, equals_script: bool) -> Explanation:
        notes = self._notes(plan)
        if equals_script:
            notes += ("the plan equals the data set's script, which the reference counts as a failure",)
        executed = [action.operator for action in trajectory.executed]
        return Explanation(
            notes,
            step_reports(self.task, self.domain, trajectory),
            goal_reports(self.task.goals, self._goals.satisfied(trajectory.final, executed)),
        )

    def _notes(self, plan: WrittenPlan) -> tuple[str, ...]:
        """What there is to say of a plan as a whole before it is run."""
        notes = repairs_told(plan.repairs)
        return notes if self._excluded is None else (*notes, f"excluded: {self._excluded}")

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan as written, or why there is none."""
        if self.protocol is Protocol.EAI_1_0_5:
            return virtualhome_reference.read_plan(text)
        return virtualhome_answer.read_plan(text)

    def resolve(self, plan: WrittenPlan) -> list[Action] | Rejected:
        """The plan as ground actions, or the first grammar error.

        Whole plans are tested for parsing (an odd list of names and ids), then hallucination, then argument
        number.
        """
        with_ids = has_ids(plan) if self._with_ids is None else self._with_ids
        if with_ids and self.protocol is Protocol.EAI_1_0_5:
            for index, step in enumerate(plan.steps):
                if len(step.arguments) % 2:
                    return _rejected(FaultKind.PARSING, index, f"{step.action}: a name without an id")
        named = [self._named(index, step, with_ids=with_ids) for index, step in enumerate(plan.steps)]
        for outcome in named:
            if isinstance(outcome, Rejected):
                return outcome
        actions = [outcome for outcome in named if isinstance(outcome, Action)]
        for index, action in enumerate(actions):
            arity = self.domain.compiled[action.operator].operator.arity
            if len(action.arguments) != arity:
                detail = f"{action.operator} takes {arity} objects, not {len(action.arguments)}"
                return _rejected(FaultKind.ARGUMENT_NUMBER, index, detail)
        return actions

    def _named(self, index: int, step: WrittenStep, *, with_ids: bool) -> Action | Rejected:
        operator = step.action.upper()
        rejected = self.protocol is Protocol.EAI_1_0_5 and operator in NOT_ACCEPTED_BY_REFERENCE
        if rejected or operator not in self.domain.compiled:
            return _rejected(FaultKind.HALLUCINATION, index, f"{step.action} is not an action")
        names = self._names.with_id(step.arguments) if with_ids else self._names.of_class(step.arguments)
        if isinstance(names, str):
            return _rejected(FaultKind.HALLUCINATION, index, f"{step.action}: there is no {names}")
        return Action(operator, names)

    def _judge(self, trajectory: Trajectory, repairs: tuple[str, ...]) -> Verdict:
        executed = [action.operator for action in trajectory.executed]
        goals = self._goals.count(trajectory.final, executed)
        failure = trajectory.failure
        error = None
        if failure is not None:
            step = len(trajectory.steps) - 1
            detail = describe(failure, self.domain, trajectory.steps[-1].action, self.task.scene)
            error = ErrorReport(failure.kind, step, detail)
        success = goals.all_satisfied and (error is None or self.protocol is Protocol.EAI_1_0_5)
        return Verdict(
            executable=error is None,
            success=success,
            error=error,
            additional_steps=trajectory.additional_steps,
            goals=goals,
            repairs=repairs,
            details=self._goals.in_data_set_order(goals, executed),
        )

    def _unread(self, plan: Unreadable) -> Verdict:
        rejection = self._rejection(ErrorReport(FaultKind.PARSING, None, plan.reason), ())
        return replace(rejection, details={"times_counted": plan.times_counted})

    def _rejection(self, error: ErrorReport | None, repairs: tuple[str, ...]) -> Verdict:
        return Verdict(
            executable=False,
            success=False,
            error=error,
            additional_steps=0,
            goals=self._goals.none_satisfied(),
            repairs=repairs,
        )

    def _reason_to_exclude(self) -> str | None:
        if self.protocol is Protocol.STRICT:
            return None if self.task.goals else NO_GOALS
        final = self.task.annotated_final
        return None if final is not None and self._goals.hold_in(final) else GOLD_TEST

    def _equals_script(self, actions: Sequence[Action]) -> bool:
        """Quirk: the reference does not run a plan that equals the data set's script, and counts no goal."""
        return self.protocol is Protocol.EAI_1_0_5 and tuple(actions) == self.task.script


class _Names:
    """What the objects of a task may be called in an answer.

    A class alone means the last relevant object of it (reference: ``get_symbolic_goal_nl``). With its id, the
    reference knows relevant objects only; `strict` takes any object that the scene has.
    """

    __slots__ = ("_by_class", "_by_name_and_id")

    def __init__(self, task: Task, protocol: Protocol) -> None:
        objects = task.scene.objects
        known = task.relevant if protocol is Protocol.EAI_1_0_5 else range(len(objects))
        self._by_class = {objects[i].category: i for i in task.relevant}
        self._by_name_and_id = {"_".join(objects[i].name.rsplit(".", 1)): i for i in known}

    def of_class(self, arguments: Sequence[object]) -> tuple[int, ...] | str:
        """The objects of these classes (the last relevant one of each), or the first unknown name."""
        return _look_up(self._by_class, arguments)

    def with_id(self, arguments: Sequence[object]) -> tuple[int, ...] | str:
        """The objects of these classes and ids in turn, or the first unknown pair."""
        keys = [f"{arguments[i]}_{arguments[i + 1]}" for i in range(0, len(arguments) - 1, 2)]
        if len(arguments) % 2:
            return f"{arguments[-1]} without an id"
        return _look_up(self._by_name_and_id, keys)


def _look_up(table: Mapping[str, int], names: Sequence[object]) -> tuple[int, ...] | str:
    indices = []
    for name in names:
        index = table.get(name) if isinstance(name, str) else None
        if index is None:
            return str(name)
        indices.append(index)
    return tuple(indices)


def has_ids(plan: WrittenPlan) -> bool:
    """Whether a plan names objects with their ids: a number stands where an id would."""
    return any(_is_id(argument) for step in plan.steps for argument in step.arguments[1::2])


def _is_id(argument: object) -> bool:
    return isinstance(argument, int) or (isinstance(argument, str) and argument.isdigit())


def _rejected(kind: FaultKind, step: int, detail: str) -> Rejected:
    return Rejected(ErrorReport(kind, step, detail))


def written_with_ids(answers: Iterable[str]) -> bool:
    """Whether most of the answers of one file that name an object name it with its id.

    The reference's two revisions each expect one form, for all answers alike.
    """
    plans = [virtualhome_reference.read_plan(answer) for answer in answers]
    readable = [plan for plan in plans if isinstance(plan, WrittenPlan)]
    named = [plan for plan in readable if any(step.arguments for step in plan.steps)]
    return sum(has_ids(plan) for plan in named) * 2 > len(named)


def domain_of(protocol: Protocol) -> Domain:
    """The VirtualHome domain as a protocol has it."""
    return virtualhome.as_meant() if protocol is Protocol.STRICT else virtualhome.as_in_reference()
