"""Play tasks by text, one action a turn, and compute the rewards of an episode."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, TypeAlias

from typing_extensions import TypedDict, assert_never

from eai.abilities.declining import ASK, REFUSE, is_clarification_question, read_reason_from_refusal_command
from eai.abilities.scorer import describe_exception
from eai.abilities.verdict import (
    ErrorReport,
    RewardInputs,
    compute_condition_gain,
    compute_plan_reward_inputs,
)
from eai.agents.command import DONE, ParsedCommand, convert_command_to_text, is_look_command
from eai.agents.game_setup import GameSetup
from eai.agents.observation import AgentMemory, make_manual
from eai.agents.rules import OUTCOMES
from eai.base.errors import EaiError, InputError
from eai.planning.search import SearchEffort
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.results.reward import Shaping, compute_reward_from_inputs, make_metrics_from_reward_inputs
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark
from eai.world.action import Action, Fault
from eai.world.episode import Episode, Slip, SlipSampler
from eai.world.execution import describe_fault
from eai.world.fault import FaultKind
from eai.world.state import State

_LOG = logging.getLogger(__name__)

GameEnd: TypeAlias = Literal["goal", "done", "refused", "steps"]
"""Reason for the end of a game: all goals reached, `DONE`, a refusal of the agent, or no actions left."""


class _GymnasiumInfo(TypedDict, total=False):
    """Facts about one turn that its observation does not show.

    Attributes:
        task_id: the task.
        goals: whether each goal is reached after the turn, in the order of the task's goals.
        won: whether the episode has ended with all goals reached, and with `DONE` if the rules require it.
        fault: the kind of error of the action; None without an error.
        slipped: whether the action was possible but, by chance, had no effect.
        repairs: names of the corrections that made a malformed command readable.
        admissible_commands: the commands for possible actions, if the rules list them.
    """

    task_id: str
    goals: list[bool]
    won: bool
    fault: str | None
    slipped: bool
    repairs: list[str]
    admissible_commands: list[str]


class _StepResult(NamedTuple):
    """The outcome of a turn, with the fields of the tuple that `gymnasium.Env.step` returns."""

    observation: str
    reward: float
    terminated: bool
    truncated: bool
    info: _GymnasiumInfo


class _CommandOutcome(NamedTuple):
    """The outcome of a command: the text for the agent, the kind of error, and whether the action slipped.

    A slip is a possible action that by chance has no effect. The text about an error or a slip is one
    sentence. After a successful action, lines with changes may follow.
    """

    text: str
    fault: FaultKind | None = None
    slipped: bool = False


class Game:
    """One game of a task, played by commands.

    Args:
        setup: the task, prepared for games.
        seed: the seed of slips, the random failures of possible actions.
        epoch: the number of the game among games of the task. Each number gives other slips with the same
            seed.

    Attributes:
        setup: the task, with the values that all games of the task share.
        task: the task.
        ended: the reason for the end of the game; None if it goes on.
        won: whether the game has ended with all goals reached, and with `DONE` if the rules require it. A
            refusal wins if no plan exists.
        refused: the agent's reason for calling the task impossible; None if the agent has not done so.
        executed_operators: names of the operators of the executed actions, in order.
        reached: whether each goal is reached now.
        value: the value of the episode in its present state, as the rules define the reward; 0 if the task
            pays no reward.
        tried_action_count: number of actions tried, impossible actions included.
        action: the action of the last command; None if the command was not an action.
        outcome: the outcome of the last command.
    """

    def __init__(self, setup: GameSetup, seed: int = 0, epoch: int = 0) -> None:
        slip_sampler = SlipSampler(setup.rules.slip, setup.task.id, seed=seed, epoch=epoch)
        self.setup, self.task = setup, setup.task
        self._rules = setup.rules
        self._episode = Episode(setup.domain, setup.task.initial, slip_sampler)
        self.executed_operators: list[str] = []
        self._last: Action | None = None
        self._turns = 0
        self._failed = False
        self._faults: Counter[FaultKind] = Counter()
        templates = PromptTemplates(variant=setup.rules.prompts)
        self._memory = AgentMemory(setup.observer, setup.rules.feedback, templates)
        self._at_start = self.reached = self._evaluate_each_goal()
        self.ended: GameEnd | None = None
        self.won = False
        self.refused: str | None = None
        self.value = 0.0
        self.tried_action_count = 0
        self.action: Action | None = None
        self.outcome = _CommandOutcome("")

    @property
    def memory(self) -> AgentMemory:
        """The agent's memory, updated to the present state even if turns report only outcomes of actions."""
        if self._memory.observation.state is not self.state:
            self._memory.update_and_describe_changes(self.state)
        return self._memory

    @property
    def is_over(self) -> bool:
        """Whether the game has ended."""
        return self.ended is not None

    @property
    def state(self) -> State:
        """The present state of the world, hidden facts included."""
        return self._episode.state

    @property
    def metrics(self) -> Mapping[str, float]:
        """The metrics of the episode up to now, by name (`eai.results.reward.METRICS`)."""
        return make_metrics_from_reward_inputs(
            self._compute_reward_inputs_of_game(is_episode_ended=self.is_over)
        )

    @property
    def reward_if_ended_now(self) -> float:
        """The value of the episode if it ends now, as the rules define the reward.

        If the rules require `DONE`, the rewards `success` and `goals` are 0 without it.
        """
        return self._compute_episode_reward(is_episode_ended=True)

    def _compute_episode_reward(self, *, is_episode_ended: bool) -> float:
        if self.refused is not None:
            return float(self.won)
        earned = self._compute_reward_inputs_of_game(is_episode_ended=is_episode_ended)
        if earned is None:
            return 0.0
        if self._rules.reward is not Shaping.REPAIR:
            return compute_reward_from_inputs(earned, self._rules.reward)
        plan: list[Action | None] = [*self._list_actions_executed_or_skipped_as_needless()]
        # a failed action must be repaired, too; a missing `DONE` counts as a step that nobody can read (None)
        if self._lacks_required_done_command(is_episode_ended=is_episode_ended):
            plan.append(None)
        elif self._failed:
            plan.append(self._last)
        return self.setup.repairer.compute_closeness_to_success(plan) or 0.0

    def _list_actions_executed_or_skipped_as_needless(self) -> list[Action]:
        """Return the actions that were executed, or skipped because they were not needed."""
        steps = self._episode.trajectory.steps
        return [
            step.action
            for step in steps
            if step.is_executed or (step.fault is not None and step.fault.kind is FaultKind.ADDITIONAL_STEP)
        ]

    def _compute_reward_inputs_of_game(self, *, is_episode_ended: bool) -> RewardInputs | None:
        if self.refused is not None:
            return RewardInputs(float(self.won), self.won, ended=False, faults=self._faults)
        # the right answer is to call the task impossible, so reached goals earn nothing
        if self.task.has_no_plan:
            return None
        ended = self._failed or self._lacks_required_done_command(is_episode_ended=is_episode_ended)
        earned = compute_plan_reward_inputs(
            self.reached, self._at_start, ended_by_error=ended, faults=self._faults
        )
        if earned is None or self._rules.reward is not Shaping.PARTIAL:
            return earned
        partial = self.setup.goals.find_partial_success(self.state, self.executed_operators, self.reached)
        gained = compute_condition_gain(partial, self.setup.share_of_conditions_met_at_start, earned.gain)
        return replace(earned, conditions=gained)

    def _lacks_required_done_command(self, *, is_episode_ended: bool) -> bool:
        """Whether the game has ended without `DONE`, although the rules require this command."""
        return is_episode_ended and self._rules.until == "done" and self.ended != "done"

    def write_manual_and_first_observation(self) -> str:
        """Return the text that an agent reads before its first action: the world, and the task."""
        manual = make_manual(self.setup.benchmark, self._rules)
        return "\n\n".join([*filter(None, [manual]), self.write_first_observation()])

    def write_first_observation(self) -> str:
        """Return the first observation: the task, the limit of actions, and the known facts."""
        text = self.setup.opening
        if self._rules.budget is not None:
            templates = PromptTemplates(variant=self._rules.prompts)
            text += f"\n\n{templates.fill_template('acting.txt', {'limit': str(self.setup.action_limit)})}"
        return f"{text}\n\n{self.memory.describe_objects_and_facts(self.memory.known)}"

    def act(self, text: str) -> _StepResult:
        """Play one turn. Any text costs an action, except the first `LOOK` after an action.

        If the world raises an exception, the action fails and the episode goes on.

        Raises:
            InputError: the episode has ended.
            EaiError: the simulator of the world has failed.
        """
        if self.is_over:
            raise InputError("the episode is over: no command can follow; begin a new one")
        text = convert_command_to_text(text)
        self.action, self._memory.changes = None, []
        turns, tried = self._turns, self.tried_action_count
        try:
            return self._take_turn(text)
        except EaiError:
            raise
        except Exception as error:
            _LOG.warning("an action in %s fails: %s", self.task.id, describe_exception(error))
            self._turns, self.tried_action_count = turns + 1, tried + 1
            kind = FaultKind.UNCATEGORISED
            self._failed, self._memory.has_looked = True, False
            self._faults[kind] += 1
            words = f"Failed ({_name_fault(kind)}): the world raised {type(error).__name__}."
            return self._make_result(_CommandOutcome(words, kind), ())

    def _take_turn(self, text: str) -> _StepResult:
        if self._rules.feedback == "changes" and is_look_command(text, self.setup.domain):
            self._turns += self._memory.has_looked
            return self._make_result(_CommandOutcome(self.memory.look_around()), ())
        special, operators = self.task.special, self.setup.domain.operator_arities
        if (
            isinstance(special, AmbiguousTaskMark)
            and ASK not in operators
            and is_clarification_question(text)
        ):
            return self._answer_agents_question(special.fits[0])
        if isinstance(special, PossiblyImpossibleTaskMark) and REFUSE not in operators:
            self.refused = read_reason_from_refusal_command(
                self.setup.benchmark.notation.plans.replace_answer_words_by_domain_names(text)
            )
            if self.refused is not None:
                return self._make_result(_CommandOutcome(f"{REFUSE}."), ())
        ends = self._rules.until == "done"
        everything = range(len(self.task.scene.objects))
        nameable = self.memory.known if self._rules.observe == "partial" else everything
        meant, repairs = self.setup.commands.read_command_and_repairs(text, nameable, may_end_episode=ends)
        self._memory.has_looked = False
        self._turns += meant is not None
        if self._has_no_actions_left:
            return self._make_result(_CommandOutcome("No actions are left."), ())
        tried = self._execute_parsed_command(meant)
        self.action = meant if isinstance(meant, Action) else None
        if meant is not None:
            self.tried_action_count += 1
            self._failed = tried.fault not in (None, FaultKind.ADDITIONAL_STEP)
            self._last = self.action
        if tried.fault is not None:
            self._faults[tried.fault] += 1
        self.reached = self._evaluate_each_goal()
        return self._make_result(tried, repairs, done=meant is None)

    def _answer_agents_question(self, meant_object: str) -> _StepResult:
        """Answer the agent's question which object the instruction means. A question costs an action."""
        self._memory.has_looked = False
        self._turns += 1
        if self._has_no_actions_left:
            return self._make_result(_CommandOutcome("No actions are left."), ())
        self.tried_action_count += 1
        name = self.setup.observer.render_names((self.task.scene.index[meant_object],))
        return self._make_result(_CommandOutcome(f"{name} is meant."), ())

    def _make_result(
        self, outcome: _CommandOutcome, repairs: tuple[str, ...], *, done: bool = False
    ) -> _StepResult:
        """End the game if a command has ended it. Return the observation and the reward of the turn."""
        self.outcome = outcome
        complete, limit = all(self.reached), self.setup.action_limit
        if self.refused is not None:
            self.ended = "refused"
        elif done:
            self.ended = "done"
        elif self._rules.until == "goal" and complete:
            self.ended = "goal"
        elif self._has_no_actions_left or (self._turns == limit and self._rules.until == "goal"):
            self.ended = "steps"
        truncated = self.ended == "steps"
        self.won = self.is_over and complete and not truncated
        if self.refused is not None:
            self.won = self.task.has_no_plan
        observation = outcome.text
        if self.is_over:
            observation += "\nAll goals are reached." if self.ended == "goal" else "\nThe episode is over."
        elif self._rules.budget is not None and limit is not None:
            observation += f"\n{limit - self._turns} of {limit} actions left."
        if self._rules.feedback == "facts":
            observation += f"\n\nNow:\n{self.memory.observation.facts_text or '-'}"
        terminated = self.is_over and not truncated
        info = self.make_gymnasium_info(
            outcome.fault, failed_by_chance=outcome.slipped, command_repairs=repairs
        )
        return _StepResult(observation, self._compute_reward(), terminated, truncated, info)

    @property
    def _has_no_actions_left(self) -> bool:
        """Whether the number of turns exceeds the limit of actions.

        After the last allowed action, `DONE` is still allowed.
        """
        return self.setup.action_limit is not None and self._turns > self.setup.action_limit

    def _compute_reward(self) -> float:
        """Return the reward of the turn: the change in the value of the episode."""
        before, self.value = self.value, self._compute_episode_reward(is_episode_ended=self.is_over)
        return self._rules.gamma * self.value - before

    def _execute_parsed_command(self, command: ParsedCommand) -> _CommandOutcome:
        if command is None:
            return _CommandOutcome(f"{DONE}.")
        if isinstance(command, ErrorReport):
            hint = f" {self.setup.commands.usage_hint}" if command.kind is FaultKind.PARSING else ""
            return _CommandOutcome(
                f"Failed ({_name_fault(command.kind)}): {command.detail}.{hint}", command.kind
            )
        line, outcome = self.setup.commands.write_command(command), self._episode.act(command)
        match outcome:
            case Fault(kind):
                reason = describe_fault(outcome, self.setup.domain, command, self.setup.task.scene)
                failed = (
                    "not needed" if kind is FaultKind.ADDITIONAL_STEP else f"failed ({_name_fault(kind)})"
                )
                return _CommandOutcome(f"{line}: {failed}: {reason}.", kind)
            case Slip():
                return _CommandOutcome(f"{line}: nothing happened.", slipped=True)
            case State():
                self.executed_operators.append(command.operator)
                if self._rules.feedback not in OUTCOMES:
                    return _CommandOutcome(
                        f"{line}: done.\n{self._memory.update_and_describe_changes(outcome)}"
                    )
                if self._rules.observe == "partial":  # objects that are visible now may be hidden later
                    self._memory.update_and_describe_changes(outcome)
                return _CommandOutcome(f"{line}: done.")
            case _:
                assert_never(outcome)

    def _evaluate_each_goal(self) -> tuple[bool, ...]:
        goals, episode = self.setup.goals, self._episode
        return goals.evaluate_each_goal(
            episode.state, self.executed_operators, episode.trajectory if goals.has_goals_over_time else None
        )

    def make_gymnasium_info(
        self,
        action_fault: FaultKind | None = None,
        *,
        failed_by_chance: bool = False,
        command_repairs: Sequence[str] = (),
    ) -> _GymnasiumInfo:
        """Return what gymnasium calls ``info``: goals reached, errors and other facts that agents do not see.

        Without arguments, the facts are those at the start of the game.
        """
        info = _GymnasiumInfo(
            task_id=self.setup.task.id,
            goals=list(self.reached),
            won=self.won,
            fault=None if action_fault is None else action_fault.value,
            slipped=failed_by_chance,
            repairs=list(command_repairs),
        )
        if self._rules.admissible:
            info["admissible_commands"] = self.list_admissible_commands()
        return info

    def list_admissible_commands(self) -> list[str]:
        """Return the commands for all possible actions about known objects, and `DONE` if it ends episodes.

        Raises:
            InputError: too many actions are possible.
        """
        bindings = SearchEffort(_MAX_BINDINGS)
        commands = [
            self.setup.commands.write_command(action) for action in self.find_possible_actions(bindings)
        ]
        if bindings.is_limit_exceeded:
            raise InputError(
                f"admissible: too many actions are possible in the task {self.task.id}; give admissible=false"
            )
        return [*commands, DONE] if self._rules.until == "done" else commands

    def find_possible_actions(self, effort: SearchEffort | None = None) -> Iterator[Action]:
        """Yield all actions that are possible now, about known objects.

        Args:
            effort: counts the parameter values that are tried. At its limit, by default `_MAX_BINDINGS`, no
                more actions are yielded.
        """
        known = self.memory.known
        objects = [index for index in self.setup.observer.subjects if index in known]
        domain, state = self.setup.domain, self._episode.state
        effort = effort or SearchEffort(_MAX_BINDINGS)
        for operator in domain.operators:
            yield from generate_applicable_actions_of_operator(domain, operator, state, objects, effort)


_MAX_BINDINGS = 1_000_000
"""Maximum number of parameter values to try when possible actions are listed."""


def _name_fault(kind: FaultKind) -> str:
    return kind.value.replace("_", " ")
