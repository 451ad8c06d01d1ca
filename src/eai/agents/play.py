"""Begin episodes of tasks, carry out commands in them, and write and read episodes as texts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, ClassVar

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from eai.abilities.experiment import MAX_SEED
from eai.abilities.notation.plans import resolve_plan
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.agents.agents import AGENTS
from eai.agents.command import DONE, CommandNotation, convert_command_to_text, is_look_command
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.observation import make_manual
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.agents.setting import (
    AGENT_SETTING_FIELD,
    HARNESSES,
    STANDARD,
    TEXT,
    AgentSetting,
    make_rules_label,
)
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import load_object
from eai.benchmarks.suite import Suite
from eai.results.codec import hash_text
from eai.tasks.options import describe_validation_error
from eai.tasks.prompts.prompt import Image, Prompt
from eai.tasks.task import Task

OVER = "The episode is over."
"""The observation after a command in an episode that is over."""

_ASSUMED_ACTIONS = 100
"""Assumed number of actions if actions are not limited. The limit of model replies is computed from it."""

_BY_TOOLS = (
    "You act by calls of tools, one at a time: act takes an action, look stands for LOOK, done for DONE."
)
BY_TEXT = "Write one command a message, on its last line: an action, LOOK or DONE."


def make_game_rules(setting: AgentSetting) -> GameRules:
    """Return the rules of games under a setting. A setting has the options that a user chooses for episodes.

    Raises:
        InputError: the view or the feedback does not exist, or the two contradict each other.
    """
    chosen = setting.model_dump(include=GameRules.model_fields.keys() & AgentSetting.model_fields.keys())
    return GameRules.read(AGENT_SETTING_FIELD, {**chosen, "until": "done", "max_steps": setting.steps})


class EpisodeFactory:
    """Makes the games and questions of a benchmark's tasks in one setting (options of episodes).

    Args:
        benchmark: the benchmark.
        setting: the setting.

    Attributes:
        rules: the rules of the games.
    """

    def __init__(self, benchmark: Benchmark, setting: AgentSetting = STANDARD) -> None:
        self.benchmark = benchmark
        self.setting = setting
        self.rules = make_game_rules(setting)

    def make_setup(self, task: Task) -> GameSetup:
        """Return a task that is ready to be played by the rules of this setting."""
        return make_setup(task, self.benchmark, self.rules)

    def make_prompt(self, task: Task) -> Prompt:
        """Return the question of a task: the world, the task, and how to act.

        A task that is left out of all statistics is not played; the question then states the reason.
        """
        if task.unplannable_reason is not None:
            return Prompt(f"{make_manual(self.benchmark, GameRules())}\n\n{task.unplannable_reason}")
        how = BY_TEXT if self.setting.harness == TEXT else _BY_TOOLS
        return Prompt(f"{Game(self.make_setup(task)).write_manual_and_first_observation()}\n\n{how}")

    def make_prompt_with_pictures(self, task: Task) -> Prompt:
        """Return the question of a task with the pictures of the first observation.

        Raises:
            InputError: objects have no 3D bodies, or a picture has no room for them.
            EaiError: the extra that draws pictures is not installed.
        """
        images = (
            ()
            if task.unplannable_reason is not None
            else self.begin_episode(task).draw_pictures_of_current_world()
        )
        return replace(self.make_prompt(task), images=images)

    def begin_episode(self, task: Task, epoch: int = 1, start_count: int = 1) -> RecordedGame:
        """Begin an episode of a task."""
        setting = self.setting
        return RecordedGame(
            self.make_setup(task), setting.slip_seed, epoch, harness=setting.harness, begun=start_count
        )

    def play_episode_and_return_commands(
        self, agent_name: str, task: Task, seed: int, epoch: int
    ) -> list[str]:
        """Let one of `AGENTS` play an episode. Return its commands."""
        game = self.begin_episode(task, epoch)
        agent = AGENTS[agent_name](game, seed + epoch - 1)
        while not game.is_over:
            game.play_command(agent())
        return [turn.said for turn in game.turns]


def make_episode_prompts_and_metadata(
    setting: AgentSetting, standard_prompts: Mapping[str, Prompt], suite: Suite
) -> tuple[Mapping[str, Prompt], Mapping[str, Mapping[str, str]]]:
    """Return two mappings by task id: the questions of episodes in a setting, and metadata with the setting.

    Raises:
        InputError: the setting names an unknown harness (program that lets models act), or a scene cannot
            be shown in pictures.
        EaiError: the extra that draws pictures is not installed.
    """
    if setting.harness not in HARNESSES:
        load_object(setting.harness)  # raises for an unknown harness, before any model is called
    about = {task_id: {AGENT_SETTING_FIELD: setting.model_dump_json()} for task_id in standard_prompts}
    if setting == STANDARD:
        return standard_prompts, about
    factory = EpisodeFactory(suite.benchmark, setting)
    return {
        task_id: factory.make_prompt_with_pictures(suite.tasks[task_id]) for task_id in standard_prompts
    }, about


def read_commands(task: Task, benchmark: Benchmark, answer: str) -> list[str]:
    """Return the commands in an answer, which is an episode, a plan or lines of commands.

    If the answer is a plan or lines, this function adds the command `DONE` at the end.
    """
    if '"turns"' in answer:
        episode = read_episode(answer)
        return [turn.said for turn in episode.turns] if isinstance(episode, StoredEpisode) else []
    plan = benchmark.notation.plans.read(answer, benchmark.domain.operator_arities)
    if isinstance(plan, Unreadable):
        return [*filter(str.strip, answer.splitlines()), DONE]
    actions = resolve_plan(
        plan, benchmark.domain, benchmark.notation.plans, benchmark.notation.plans.make_object_lookup(task)
    )
    if isinstance(actions, ErrorReport):
        return [*(f"{step.action}({', '.join(map(str, step.objects))})" for step in plan.steps), DONE]
    return [*map(CommandNotation(task, benchmark).write_command, actions), DONE]


_MAX_TURNS = 100_000
"""Maximum number of turns in a stored episode. Longer episodes are not read."""

_MAX_NAME_LENGTH = 100
"""Maximum number of characters of the name of a harness, the program that lets a model act."""


MAX_QUOTED_REPLY = 300
"""Maximum number of characters that an episode keeps of a reply that called no tool."""

_Count = Annotated[int, Field(ge=0, le=MAX_SEED)]
_Seed = Annotated[int, Field(ge=-MAX_SEED, le=MAX_SEED)]
_Harness = Annotated[str, Field(max_length=_MAX_NAME_LENGTH, pattern=r"^$|[^.]")]
"""Type of the name of a harness (program that lets a model act). It becomes part of a file's name.

The name is empty, or has a character other than a dot.
"""


@dataclass(frozen=True, slots=True)
class _CommandInEpisodeText:
    """A command of an agent, as the text of an episode stores it.

    Attributes:
        said: the command.
        told: digest of the game's reply to the command; None if unknown.
        thought: the text that the agent wrote with the command; empty if it equals the last thought.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    said: str
    told: str | None = None
    thought: str = ""


@dataclass(frozen=True, slots=True)
class StoredEpisode:
    """An episode as a stored answer, which a scorer can replay.

    Attributes:
        turns: the commands of the episode, in order.
        rules: the rules of the game; None for the standard setting.
        seed: the seed of slips, the random failures of possible actions.
        epoch: the number of the episode among episodes with this seed.
        harness: the harness of the agent; empty if unknown.
        begun: how often the episode was started; the last start counts.
        opening: digest of the first observation.
        ended: reason for the end of the episode, as the player states it.
        without_call: the beginning of the first reply that called no tool; empty if each reply called a tool.
            In the harness ``auto``, later commands are lines of text.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    turns: Annotated[tuple[_CommandInEpisodeText, ...], Field(max_length=_MAX_TURNS)]
    rules: GameRules | None = None
    seed: _Seed = 0
    epoch: _Count = 1
    harness: _Harness = ""
    begun: _Count = 1
    opening: str | None = None
    ended: str = "stopped"
    without_call: Annotated[str, Field(max_length=MAX_QUOTED_REPLY)] = ""


@cache
def _get_episode_adapter() -> TypeAdapter[StoredEpisode]:
    return TypeAdapter(StoredEpisode)


def read_episode(text: str) -> StoredEpisode | Unreadable:
    """Read an episode: JSON from `RecordedGame.write_as_json_text`, or one command per line."""
    if not text.lstrip().startswith("{") or '"turns"' not in text:
        return _read_command_lines([line.strip() for line in text.splitlines() if line.strip()])
    try:
        return _get_episode_adapter().validate_json(text)
    except ValidationError as error:
        return Unreadable(describe_validation_error(error, whole="the episode"))
    except InputError as error:
        return Unreadable(f"rules: {error}")


RULE_NAMES = {
    **{name: name for name in ("view", "observe", "feedback", "prompts", "slip", "slip_seed", "budget")},
    "max_steps": "steps",
    **{name: name for name in ("until", "reward", "gamma", "admissible", "verifier")},
}
"""Mapping from each rule of an episode to its name in the texts that `make_label_of_nonstandard_rules` makes.

These texts list the rules in the order of the mapping.
"""


def make_label_of_nonstandard_rules(episode: StoredEpisode) -> str | None:
    """Return a text with the rules of an episode that differ from the standard setting.

    The text has the form of `AgentSetting.label`. The result is None if no rule differs. The seed of random
    failures (slips) is a rule, because a player could choose a lucky seed.
    """
    standard = make_game_rules(STANDARD)
    rules = episode.rules or standard
    values = {**rules.model_dump(mode="json"), "slip_seed": episode.seed if rules.slip else 0}
    usual = {**standard.model_dump(mode="json"), "slip_seed": 0}
    different = {RULE_NAMES[name]: values[name] for name in RULE_NAMES if values[name] != usual[name]}
    return make_rules_label(different) or None


def _read_command_lines(lines: Sequence[str]) -> StoredEpisode | Unreadable:
    if len(lines) > _MAX_TURNS:
        return Unreadable(f"an episode has at most {_MAX_TURNS:,} turns, and this one {len(lines):,}")
    return StoredEpisode(tuple(map(_CommandInEpisodeText, lines)))


def _replace_surrogates(text: str) -> str:
    """Replace invalid characters (lone surrogates) by question marks, because readers of JSON reject them."""
    return text.encode(errors="replace").decode()


class RecordedGame(Game):
    """A game that records its commands as an episode.

    Args:
        setup: the task, prepared for games.
        seed: the seed of slips, the random failures of possible actions.
        epoch: the number of the episode, from 1 on. Each number gives other slips with the same seed.
        harness: the harness of the agent.
        begun: how often the episode was started, this start included.

    Attributes:
        turns: the commands so far.
        failed: for each command, whether its action was impossible or slipped.
        max_actions: the limit of actions; 100 if actions are not limited. The limit of a model's replies is a
            multiple of it.
        harness: the harness of the agent.
        without_call: the first reply that called no tool; empty if each reply called a tool.
    """

    def __init__(self, setup: GameSetup, seed: int, epoch: int, *, harness: str = "", begun: int = 1) -> None:
        super().__init__(setup, seed, epoch)
        self.turns: list[_CommandInEpisodeText] = []
        self.failed: list[bool] = []
        self.max_actions = setup.action_limit or _ASSUMED_ACTIONS
        self.harness = harness
        self.without_call = ""
        self._thought = ""
        self._about = StoredEpisode(
            (), setup.rules, seed, epoch, "", begun, hash_text(self.write_first_observation())
        )

    def play_command(self, command: str, thought: str = "") -> str:
        """Carry out a command, and record it with the agent's thought. Return the observation.

        The command `LOOK` is recorded only under the rule ``feedback=changes``. Under other values of
        ``feedback``, `LOOK` leaves the episode unchanged.
        """
        if self.is_over:
            return OVER
        command = convert_command_to_text(command)
        if self.setup.rules.feedback != "changes" and is_look_command(command, self.setup.domain):
            return self.memory.look_around()
        command, thought = _replace_surrogates(command), _replace_surrogates(thought)
        told = self.act(command).observation
        self.turns.append(
            _CommandInEpisodeText(command, hash_text(told), "" if thought == self._thought else thought)
        )
        self.failed.append(self.outcome.fault is not None or self.outcome.slipped)
        self._thought = thought
        return told

    def draw_pictures_of_current_world(self) -> tuple[Image, ...]:
        """Return pictures of the present world; none after the end or without feedback by pictures.

        Raises:
            InputError: objects have no 3D bodies, or a picture has no room for them.
            EaiError: the extra that draws pictures is not installed.
        """
        if self.setup.rules.feedback != "pictures" or self.is_over:
            return ()
        rendered = load_from_extension("rendered_pictures", "feedback pictures")
        images: tuple[Image, ...] = rendered.render_task_images(
            self.task, rendered.VIEWS[:2], state=self.state
        )
        return images

    def write_as_json_text(self, end_reason: str) -> str:
        """Return the episode as a JSON text. ``end_reason`` says why an unfinished game stopped."""
        return json.dumps(self.to_json(end_reason), ensure_ascii=False)

    def to_json(self, end_reason: str) -> dict[str, Any]:
        """Return the episode as a JSON object. ``end_reason`` says why an unfinished game stopped."""
        end_reason = self.ended or end_reason
        episode = replace(
            self._about,
            turns=tuple(self.turns),
            harness=self.harness,
            ended=end_reason,
            without_call=_replace_surrogates(self.without_call)[:MAX_QUOTED_REPLY],
        )
        written: dict[str, Any] = _get_episode_adapter().dump_python(episode, mode="json")
        if not self.without_call:
            del written["without_call"]
        for turn in written["turns"]:
            if not turn["thought"]:
                del turn["thought"]
        return written
