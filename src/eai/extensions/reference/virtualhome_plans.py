"""Score VirtualHome plans as eai-eval 1.0.5 does (``action_sequencing/scripts/``, ``eval_utils.py``).

Defects of its goal test:

- The loop over relation goals ends at the first goal that holds (``scene_evaluate_wID``): at most one counts.
- The text of all actions is searched for the action goals, as substrings. If a goal has alternatives, the
  first alternative in its list that occurs counts, not the alternative that occurs earliest in the plan
  (``check_order_with_or_score``). The search ends at the first goal without a match.
- The search takes action goals in the order of a set of strings, which changes from run to run. Verdicts use
  the order of hash seed 0: alphabetical order for the 13 tasks with two action goals.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from functools import cache

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, TOO_LONG
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.notation.plan_form import WrittenPlan, WrittenStep
from eai.abilities.notation.plans import Execution, PlanExecutor
from eai.abilities.scorer import Assessment
from eai.abilities.verdict import ErrorReport, PlanVerdict, SummaryCounts, Unreadable
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_paper_order
from eai.benchmarks.virtualhome.plan_notation import (
    ObjectWithId,
    VirtualHomePlanNotation,
    has_object_ids,
    join_object_classes_and_ids_in_plan,
    make_object_index_lookup,
)
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask
from eai.extensions.reference import virtualhome_quirks
from eai.extensions.reference.plans import add_notes_on_strict_protocol
from eai.extensions.reference.virtualhome_quirks import list_task_objects_in_published_order
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory
from eai.world.fault import FaultKind
from eai.world.state import Scene, State


class _VirtualHomeGoalTest(GoalTest):
    """Test of the goals of a task, with the defects (quirks) of eai-eval, the paper's package.

    Args:
        task: the task.
        in_data_set_order: whether the plan must meet action goals in the order of the data set, and not in
            alphabetical order.
    """

    def __init__(self, task: Task, *, in_data_set_order: bool = False) -> None:
        super().__init__(task)
        numbers = range(len(self._actions))
        self._order = numbers if in_data_set_order else sorted(numbers, key=self._actions.__getitem__)
        self._relations = [i for i, goal in enumerate(task.goals) if goal.kind is GoalKind.RELATION]
        self.reorders = list(self._order) != list(numbers)

    def evaluate_each_goal(
        self, final: State, actions: Sequence[str], execution: Trajectory | None = None
    ) -> tuple[bool, ...]:
        """Return for each goal whether it counts as reached. Only the first true relation goal counts."""
        reached = list(super().evaluate_each_goal(final, actions, execution))
        held = [number for number in self._relations if reached[number]]
        for number in held[1:]:
            reached[number] = False
        return tuple(reached)

    def are_goals_reached_in_gold_final_state(self, gold_final_state: State) -> bool:
        """Whether all state and relation goals count as reached in the data set's recorded final state."""
        reached = self.evaluate_each_goal(gold_final_state, ())
        return all(reached[i] for i in range(len(reached)) if i not in self._action_indices)

    def _find_indices_of_met_action_goals(
        self, goals: Sequence[tuple[str, ...]], actions: Sequence[str]
    ) -> Sequence[int]:
        """Return the indices of the action goals that count as met.

        The plan is searched for the goals in order. Those before the first goal without a match are met.
        """
        text = " ".join(actions)
        position = 0
        for count, number in enumerate(self._order):
            match = next((word for word in goals[number] if text.find(word, position) >= 0), None)
            if match is None:
                return self._order[:count]
            position = text.find(match, position) + len(match)
        return self._order


NOT_ACCEPTED = ("PLUGIN", "PLUGOUT", "RELEASE")
"""Names of actions that prompts offer, but eai-eval's vocabulary test rejects (``valid_actions``)."""

GOLD_TEST = "the data set's own final state fails the reference's goal test"
EQUALS_SCRIPT = "the plan equals the data set's script, which the reference counts as a failure"

LIST_IS_NOT_JSON = Unreadable("the list of a step is not JSON")
"""Reason why an answer cannot be read; in eai-eval's summary, this error counts as two parsing errors."""

_STEP = re.compile(r'"(\w+)"\s*:\s*(\[[^\]]+\])')
_FENCE = "```json"
_LIST_END = "]"


class _VirtualHomePlanNotation(VirtualHomePlanNotation):
    """The notation of VirtualHome plans, read as eai-eval (the paper's package) reads it.

    Args:
        with_ids: whether plans name objects by class and id, as in release 1.0.5, or by class only, as in the
            paper's answers. If None, each answer is read in the form that it has.
    """

    def __init__(self, *, with_ids: bool | None = None) -> None:
        self._with_ids = with_ids

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in an answer. If the plan names objects with ids, every name needs an id."""
        plan = read_plan(text)
        with_ids = self._with_ids
        if isinstance(plan, Unreadable) or not (has_object_ids(plan) if with_ids is None else with_ids):
            return plan
        for number, step in enumerate(plan.steps):
            if len(step.objects) % 2:
                return Unreadable(f"{step.action}: a name without an id", number)
        return join_object_classes_and_ids_in_plan(plan)

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return a function from a name to the index of a relevant object of the task, or None.

        A name and its id are joined to one text, such as ``soap_1002``, and this text is looked up
        (``check_no_hallucination_in_arg``).
        """
        if not isinstance(task, VirtualHomeTask):
            raise TypeError(
                f"task {task.id} is not from the data set of VirtualHome, which this protocol needs"
            )
        relevant = list_task_objects_in_published_order(task)
        objects = task.scene.objects
        by_class = {objects[i].category: i for i in relevant}
        by_name = {"_".join(objects[i].name.rsplit(".", 1)): i for i in relevant}
        return make_object_index_lookup(by_class, by_name, class_id_separator="_")


class VirtualHomeActionSequencingScorer(ActionSequencingScorer):
    """Scores plans for a task of VirtualHome as eai-eval (the paper's package) does.

    A task is excluded if its final state in the data set fails the goal test. A plan that equals the data
    set's own plan fails: eai-eval does not execute it, so it reaches no goal. A plan that reaches all goals
    succeeds, even if a later step fails.
    """

    def __init__(self, task: VirtualHomeTask, *, with_ids: bool | None = None) -> None:
        goals = _VirtualHomeGoalTest(task)
        super().__init__(task, _make_domain(), _VirtualHomePlanNotation(with_ids=with_ids), goals)
        final = task.annotated_final
        passes = final is not None and goals.are_goals_reached_in_gold_final_state(final)
        self.excluded = None if passes else task.make_exclusion(GOLD_TEST)
        self._summary_goals = _VirtualHomeGoalTest(task, in_data_set_order=True) if goals.reorders else goals

    def assess(self, text: str) -> Assessment:
        """Return the verdict, and an explanation that also has the verdict by the protocol `strict`.

        This protocol follows the text of the paper.
        """
        return add_notes_on_strict_protocol(
            super().assess(text), text, self.notation, self._make_scorer_of_strict_protocol
        )

    def _make_scorer_of_strict_protocol(self) -> ActionSequencingScorer:
        return ActionSequencingScorer(
            self.task, make_domain_with_checks_in_paper_order(), VirtualHomePlanNotation()
        )

    def _make_rejection_verdict(
        self, error: ErrorReport, plan: WrittenPlan, execute: PlanExecutor
    ) -> PlanVerdict:
        verdict = super()._make_rejection_verdict(error, plan, execute)
        if error.detail != LIST_IS_NOT_JSON.reason:
            return verdict
        goals = self.goals.tally_by_kind(verdict.goals_satisfied)
        twice = SummaryCounts(success=False, goals=goals, errors={FaultKind.PARSING: 2})
        return replace(verdict, counted=twice)

    def _execute_and_assess(
        self, plan: WrittenPlan, actions: tuple[Action, ...], execute: PlanExecutor
    ) -> Assessment:
        if actions != self.task.script or not _are_all_objects_named_by_class(plan, actions, self.task.scene):
            return super()._execute_and_assess(plan, actions, execute)
        assessment_if_run = super()._execute_and_assess(plan, actions, self._execute_from_start)
        not_run = self._make_verdict(self.goals.none_reached, plan, success=False)
        return Assessment(not_run, lambda: _add_note(assessment_if_run.explain(), EQUALS_SCRIPT))

    def _judge_execution(self, execution: Execution, plan: WrittenPlan) -> PlanVerdict:
        """Return the verdict on an executed plan.

        The package eai-eval judges each plan by itself, and again in a summary of all answers. If the summary
        counts other errors or goals, the verdict has these counts in ``counted``. The summary counts every
        action that was not needed as an error. It requires action goals in the order of the data set. When
        eai-eval judges a plan by itself, action goals have this order only by chance.
        """
        verdict = super()._judge_execution(execution, plan)
        reached = verdict.goals_satisfied
        if self._summary_goals is not self.goals:
            reached = self._summary_goals.evaluate_each_goal(
                execution.trajectory.final_state, execution.names_of_all_executed_actions
            )
        additional = execution.trajectory.needless_step_count
        if reached == verdict.goals_satisfied and additional < 2:
            return verdict
        errors = {} if verdict.error is None else {verdict.error.kind: 1}
        errors |= {FaultKind.ADDITIONAL_STEP: additional} if additional else {}
        return replace(
            verdict, counted=SummaryCounts(all(reached), self.goals.tally_by_kind(reached), errors)
        )

    def _is_success(self, error: ErrorReport | None, reached: tuple[bool, ...]) -> bool:
        return all(reached)


def _are_all_objects_named_by_class(plan: WrittenPlan, actions: Sequence[Action], scene: Scene) -> bool:
    """Whether a plan names every object by its class. The data set's plan always does so.

    eai-eval compares the texts of plans, so a plan with other names differs from the data set's plan. For
    instance, ``["food", "egg_1003"]`` and ``["food_egg", "1003"]`` name the same object, but only the second
    begins with its class.
    """
    return all(
        not isinstance(word, ObjectWithId) or word.name == scene.objects[index].category
        for step, action in zip(plan.steps, actions, strict=True)
        for word, index in zip(step.objects, action.arguments, strict=True)
    )


def _add_note(explanation: VerdictExplanation, note: str) -> VerdictExplanation:
    return replace(explanation, notes=(*explanation.notes, note))


@cache
def _make_domain() -> Domain:
    return virtualhome_quirks.make_domain_with_all_quirks().replace_operators(without=NOT_ACCEPTED)


def do_most_answers_use_object_ids(answers: Iterable[str]) -> bool:
    """Whether most answers of a file use ids. Answers that name no objects are not counted."""
    plans = [read_plan(answer) for answer in answers]
    readable = [plan for plan in plans if isinstance(plan, WrittenPlan)]
    named = [plan for plan in readable if any(step.objects for step in plan.steps)]
    return sum(has_object_ids(plan) for plan in named) * 2 > len(named)


def read_plan(text: str) -> WrittenPlan | Unreadable:
    """Return the steps that eai-eval finds in an answer, in order (``load_json_preserving_order``).

    A step with an empty list (``"STANDUP": []``) is lost. Text around the steps is ignored. Only a code fence
    at the very start is removed.
    """
    if len(text) > MAX_ANSWER_CHARACTERS:
        return TOO_LONG
    # Every step ends with a list. Removing the text after the last list makes the search for steps faster.
    text = text[: text.rfind(_LIST_END) + 1]
    text = text.removeprefix(_FENCE).strip().replace("\n", "").replace("'", '"')
    written = _STEP.findall(re.sub(r"\s+", " ", text))
    if not written:
        return Unreadable("no step was found")
    try:
        # Each list is on its own line. JSON strings contain no line break, so no string spans two lists.
        lists = json.loads("[" + ",\n".join([arguments for _, arguments in written]) + "]")
    except (ValueError, RecursionError):
        return LIST_IS_NOT_JSON
    return WrittenPlan(
        tuple(WrittenStep(name, tuple(args)) for (name, _), args in zip(written, lists, strict=True))
    )
