"""Score episodes: replay the commands of each episode in a new world of its task.

The scorer also decides whether the goals can still be reached after each turn, or are lost for good. Lost
goals stay lost, so bisection finds the first turn after which they are out of reach.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from textwrap import shorten
from typing import Any, TypeAlias

from eai.abilities.declaration import DomainAndNotation, QuestionAndAnswer
from eai.abilities.explanation import EXECUTED, SLIP, AtomOrAction, StepReport, VerdictExplanation
from eai.abilities.reports import report_goals, to_action_with_object_names
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import UNREPLAYABLE, ErrorReport, Unreadable
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.play import EpisodeFactory, StoredEpisode, make_game_rules, read_episode
from eai.agents.reference import make_setup
from eai.agents.setting import AUTO, STANDARD
from eai.agents.verdict import EpisodeTurn, EpisodeVerdict, Recoverability
from eai.benchmarks.benchmark import Benchmark
from eai.planning.planner import get_planner
from eai.planning.search import Limits, SearchEndReason
from eai.results.codec import hash_text
from eai.tasks.goal_test import GoalTest, find_remaining_goals
from eai.tasks.planning import find_plan
from eai.tasks.task import Task, TaskExclusion
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.state import State

_ENDS = frozenset({"stopped", "tokens", "time", "turns", "crashed"})
"""Reasons, stated in an episode, for which its player stopped before the game was over."""

_TOO_LATE = "too_late"
"""Outcome of an action that exceeds the maximum number of actions."""


def _get_benchmark(domain_and_notation: DomainAndNotation) -> Benchmark:
    if not isinstance(domain_and_notation.benchmark, Benchmark):
        raise TypeError("the ability acting needs a `Benchmark`: open the tasks with `eai.open`")
    return domain_and_notation.benchmark


def make_scorer_factory(domain_and_notation: DomainAndNotation) -> Callable[[Task], Scorer]:
    """Return the function that makes the scorer of a task of a benchmark."""
    return partial(_EpisodeScorer, benchmark=_get_benchmark(domain_and_notation))


def make_question_and_winning_answer(domain_and_notation: DomainAndNotation, task: Task) -> QuestionAndAnswer:
    """Return the question of a task in the standard setting, and commands that win the episode."""
    factory = EpisodeFactory(_get_benchmark(domain_and_notation))
    commands = factory.make_setup(task).reference.commands if task.unplannable_reason is None else None
    end = [] if task.has_no_plan else [DONE]
    return factory.make_prompt(task).user, "\n".join([*(commands or ()), *end])


NO_REFERENCE = "nobody is known to win the task with what is seen in the standard setting"
"""Reason for excluding a task in all settings: nobody knows commands that win it."""


class _EpisodeScorer(Scorer):
    """The scorer of the episodes of one task.

    Args:
        task: the task.
        benchmark: the benchmark of the task.
    """

    def __init__(self, task: Task, benchmark: Benchmark) -> None:
        self.task = task
        self.benchmark = benchmark
        self.domain = benchmark.domain  # other modules read this attribute
        self.goals = GoalTest(task)

    def find_exclusion(self) -> TaskExclusion | None:
        """Return the reason for leaving the task out of all games, or None.

        This method does not search for winning commands, which would take longer.
        """
        return self.task.unplannable_reason

    @cached_property
    def _exclusion_if_no_winning_game_found(self) -> TaskExclusion | None:
        """The reason for leaving the task out of statistics if no search finds commands that win it.

        None if the task counts.
        """
        if self.task.unplannable_reason is not None:
            return self.task.unplannable_reason
        setup = make_setup(self.task, self.benchmark, make_game_rules(STANDARD).rules_for_episode_replay)
        return self.task.make_exclusion(NO_REFERENCE) if setup.reference.commands is None else None

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an episode.

        The episode fails if its replay gives other observations; the verdict then names the turn.
        """
        excluded = self._exclusion_if_no_winning_game_found
        if excluded is not None:
            return Assessment(EpisodeVerdict(excluded=excluded), lambda: VerdictExplanation((excluded,)))
        read = read_episode(text)
        episode = StoredEpisode(()) if isinstance(read, Unreadable) else read
        rules = episode.rules or make_game_rules(STANDARD)
        verdict, steps, history = self._replay_episode(
            make_setup(self.task, self.benchmark, rules.rules_for_episode_replay), episode
        )
        if isinstance(read, Unreadable):
            unread = ErrorReport(FaultKind.PARSING, None, read.reason)
            verdict = replace(verdict, error=unread, executable=False)
        return self._make_assessment(verdict, steps, history)

    def _replay_episode(
        self, setup: GameSetup, episode: StoredEpisode
    ) -> tuple[EpisodeVerdict, list[StepReport], list[StateAndTakenActions]]:
        game = Game(setup, episode.seed, episode.epoch)
        difference = _describe_observation_difference(
            "the first observation", episode.opening, game.write_first_observation()
        )
        states: dict[Any, int] = {(game.state, game.reached): 0}
        turns, steps = [], []
        history: list[StateAndTakenActions] = [(game.state, ())]
        for number, command in enumerate(episode.turns, 1):
            if difference is not None:
                break
            if game.is_over:
                difference = f"turn {number}: the episode is over"
                break
            tried_before = game.tried_action_count
            told = game.act(command.said).observation
            difference = _describe_observation_difference(f"turn {number}", command.told, told)
            first = states.setdefault((game.state, game.reached), number)
            turns.append(
                EpisodeTurn(
                    command.said,
                    hash_text(told),
                    is_action=game.tried_action_count > tried_before,
                    fault=game.outcome.fault,
                    slipped=game.outcome.slipped,
                    goals="".join("1" if reached else "0" for reached in game.reached),
                    same_as=first if first < number else None,
                )
            )
            steps.append(_make_step_report(turns[-1], game))
            history.append((game.state, tuple(game.executed_operators)))
        claimed = episode.ended if episode.ended in _ENDS else "stopped"
        verdict = self._make_verdict(game, episode, tuple(turns), game.ended or claimed)
        return (
            verdict if difference is None else self._mark_episode_as_unreplayable(verdict, difference),
            steps,
            history,
        )

    def _mark_episode_as_unreplayable(
        self, verdict: EpisodeVerdict, replay_difference: str
    ) -> EpisodeVerdict:
        """Return the verdict on an episode whose replay differs: no goal counts as reached."""
        step = len(verdict.turns) - 1 if verdict.turns else None
        return replace(
            verdict,
            error=ErrorReport(
                FaultKind.UNCATEGORISED, step, f"{UNREPLAYABLE}: {replay_difference}", UNREPLAYABLE
            ),
            executable=False,
            success=False,
            goals=self.goals.tally_by_kind(self.goals.none_reached),
            goals_satisfied=self.goals.none_reached,
            partial=self.goals.partial_success_of_unexecuted_answer,
            ended="stopped",
            refused=None,
            declared=False,
            reached=False,
        )

    def _make_verdict(
        self, game: Game, episode: StoredEpisode, turns: tuple[EpisodeTurn, ...], ended: str
    ) -> EpisodeVerdict:
        """Return the verdict on an episode after the last replayed turn.

        If no turn was played, no goal counts as reached, even if it holds at the start.
        """
        setup, held = game.setup, game.reached if turns else self.goals.none_reached
        faults = [turn.fault for turn in turns if turn.fault is not None]
        additional = faults.count(FaultKind.ADDITIONAL_STEP)
        return EpisodeVerdict(
            executable=len(faults) == additional,
            success=game.won,
            additional_steps=additional,
            goals=self.goals.tally_by_kind(held),
            goals_satisfied=held,
            partial=self.goals.find_partial_success(game.state, game.executed_operators, held)
            if turns
            else self.goals.partial_success_of_unexecuted_answer,
            turns=turns,
            ended=ended,
            refused=game.refused,
            declared=ended == "done",
            reached=bool(turns) and all(held),
            shortest=setup.reference.shortest,
            budget=setup.action_limit,
            view=f"{setup.rules.view}, {setup.rules.observe}",
            harness=episode.harness,
            begun=episode.begun,
            without_call=episode.without_call or None,
        )

    def _make_assessment(
        self, verdict: EpisodeVerdict, steps: list[StepReport], history: list[StateAndTakenActions]
    ) -> Assessment:
        def add_goal_reachability_to_verdict(max_states: int) -> EpisodeVerdict:
            if self.task.has_no_plan:
                return verdict
            if verdict.is_unreplayable:
                return replace(verdict, outlook="unknown")
            if verdict.success:
                return replace(verdict, outlook="open")
            outlook, lost_at = find_if_and_when_goals_become_unreachable(
                self.task, self.benchmark.domain, history, max_states
            )
            return replace(verdict, outlook=outlook, lost_at=lost_at)

        def explain_episode_verdict() -> VerdictExplanation:
            notes = [] if verdict.error is None else [f"{verdict.error.kind.value}: {verdict.error.detail}"]
            notes.append(
                f"ended: {verdict.ended}; {len(verdict.action_turns)} actions, at most {verdict.budget}"
            )
            if verdict.shortest is not None:
                notes.append(f"the shortest known plan has {verdict.shortest}")
            if verdict.without_call is not None:
                quoted = shorten(verdict.without_call, _MAX_SHOWN, placeholder=" ...")
                later = " (later commands are lines of text)" * (verdict.harness == AUTO)
                notes.append(f"a reply called no tool{later}: {quoted}")
            if verdict.begun > 1:
                notes.append(f"begun {verdict.begun} times; the last one counts")
            goals = report_goals(self.task, verdict.goals_satisfied)
            return VerdictExplanation(tuple(notes), tuple(steps), goals)

        return Assessment(verdict, explain_episode_verdict, add_goal_reachability_to_verdict)


_MAX_SHOWN = 100
"""Maximum number of characters that an explanation quotes of an observation or a reply."""


def _describe_observation_difference(
    turn_name: str, recorded_digest: str | None, observation: str
) -> str | None:
    """Return a text on an observation that differs from its digest in the episode; None if it agrees."""
    if recorded_digest is None or recorded_digest == hash_text(observation):
        return None
    first = observation.partition("\n")[0]
    return f"{turn_name}: the observation is another one: {first[:_MAX_SHOWN]}"


def _make_step_report(turn: EpisodeTurn, game: Game) -> StepReport:
    """Return the entry of a turn in the explanation of a verdict.

    The reason of a failure is always one line, even if an object's name has a line break.
    """
    reason, fact = game.outcome.text.partition("\n")[0], game.setup.observer.render_fact
    fault = SLIP if turn.slipped else EXECUTED if turn.fault is None else turn.fault.value
    if game.ended == "steps" and not turn.is_action:
        fault = _TOO_LATE
    return StepReport(
        turn.said,
        fault,
        "" if fault == EXECUTED else reason,
        added=tuple([fact(changed_fact) for sign, changed_fact in game.memory.changes if sign == "+"]),
        removed=tuple([fact(changed_fact) for sign, changed_fact in game.memory.changes if sign == "-"]),
        call=AtomOrAction(turn.said, None)
        if game.action is None
        else to_action_with_object_names(game.action, game.task.scene),
    )


StateAndTakenActions: TypeAlias = tuple[State, Sequence[str]]
"""The state of the world after a turn, and the names of the operators of all actions executed up to then."""


def find_if_and_when_goals_become_unreachable(
    task: Task, domain: Domain, history: Sequence[StateAndTakenActions], max_states: int
) -> tuple[Recoverability, int | None]:
    """Return whether the goals can be reached at the end, and the turn after which they no longer can.

    The turn is the first such turn, from 1 on; 0 if the goals never could be reached; None if the goals are
    not lost.

    The agent may use all objects of the scene, seen or not, and any number of actions. A plan shows that the
    goals can be reached. A search through all reachable states shows that the goals are lost. For goals over
    time, which concern all states of an episode, a plan does not show that the goals can be reached.

    Args:
        task: the task.
        domain: the domain.
        history: the state and the executed operators at the start, and after each turn.
        max_states: maximum number of states that each search may reach; if it is too small, the result is
            ``unknown``.
    """
    last = _search_goal_reachability(task, domain, history[-1], max_states)
    if last != "lost":
        return last, None
    return last, bisect_left(
        history[:-1], True, key=lambda at: _search_goal_reachability(task, domain, at, max_states) == "lost"
    )


def _search_goal_reachability(
    task: Task, domain: Domain, state_and_actions: StateAndTakenActions, max_states: int
) -> Recoverability:
    state, taken = state_and_actions
    now = replace(task, initial=state, goals=find_remaining_goals(task, taken))
    end = SearchEndReason.STATES
    for objects in (task.relevant, tuple(range(len(task.scene.objects)))):
        end = find_plan(replace(now, relevant=objects), get_planner(domain), Limits(max_states)).end
        if end is SearchEndReason.SOLVED:
            is_temporal = any(goal.is_temporal for goal in task.goals)
            return "unknown" if is_temporal else "open"
    return "lost" if end is SearchEndReason.UNREACHABLE else "unknown"
