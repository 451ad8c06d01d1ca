"""Lets models act in Inspect: the tools of a task, commands as text, and solvers that play an episode.

The state of an episode is in Inspect's store, as JSON, after every command. ``eai_enter`` puts the tools into
the state of a sample, so that any solver finds them. ``eai/player`` is the default solver.
"""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Iterator, Mapping
from functools import cache
from typing import Any

from inspect_ai.agent import AgentState, react
from inspect_ai.event import ModelEvent
from inspect_ai.log import EvalSample, transcript
from inspect_ai.model import ChatMessageUser, Content, ModelOutput, StopReason, get_model
from inspect_ai.solver import Generate, Solver, TaskState, solver
from inspect_ai.tool import ToolDef, ToolError, ToolParams
from inspect_ai.util import StoreModel, apply_limits, registry_info, time_limit, token_limit, turn_limit
from pydantic import Field

from eai.abilities.attempt import AnswerUsage
from eai.abilities.protocol import Ability
from eai.agents.command import DONE
from eai.agents.play import BY_TEXT, EpisodeFactory, RecordedGame
from eai.agents.setting import AUTO, HARNESSES, TEXT, AgentSetting
from eai.agents.tools import convert_tool_call_to_command, list_tool_names_texts_and_schemas
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark, load_object
from eai.benchmarks.suite import open_suite
from eai.run.job import ERRATA, KEPT_TASKS, is_built_in_model
from eai.run.journal import RunState
from eai.run.request_errors import describe_error
from eai.run.solver import (
    add_epoch_to_metadata,
    find_reasoning,
    is_error_about_refused_parameter,
    make_answer,
    make_message_content,
    put_recorded_answer_into_state,
    read_usage,
    report_failure_in_block,
    split_reply,
)
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import ErrataChoice, Source, find_errata_choice
from eai.tasks.task import Task

BEGUN = "begun"
"""Field of a sample's metadata: the number of times that its episode has begun."""

_REPLIES_PER_TURN = 3
"""Maximum number of replies of a model for each turn of its game."""

_ENDED_BY_LIMIT = {"token": "tokens", "time": "time", "turn": "turns"}


class _EpisodeInInspectStore(StoreModel):
    """The episode up to the last command, as Inspect's store holds it."""

    episode: dict[str, Any] = Field(default_factory=dict)


def read_episode_text(state: TaskState | EvalSample) -> str:
    """Return the episode in a sample's store as text, or the sample's output if there is no episode."""
    episode = state.store_as(_EpisodeInInspectStore).episode
    return json.dumps(episode, ensure_ascii=False) if episode else state.output.completion


@cache
def _open_tasks(benchmark: Benchmark, ability: Ability, errata: ErrataChoice) -> Mapping[str, Task]:
    return open_suite(benchmark, ability, source=Source(errata=errata, kept=KEPT_TASKS)).tasks


def _begin_episode(state: TaskState) -> RecordedGame | None:
    """Begin the episode of a sample, and replay the commands that Inspect's store has of it.

    Return None if the task cannot be played.
    """
    metadata = state.metadata
    errata = find_errata_choice(metadata.get(ERRATA, ErrataChoice.CURRENT))
    benchmark = find_benchmark(str(metadata["domain"]))
    task = _open_tasks(benchmark, Ability(metadata["ability"]), errata)[str(state.sample_id)]
    if task.unplannable_reason is not None:
        return None
    play = EpisodeFactory(benchmark, AgentSetting.from_metadata(metadata)).begin_episode(
        task, state.epoch, int(metadata.get(BEGUN, 1))
    )
    for turn in state.store_as(_EpisodeInInspectStore).episode.get("turns", ()):
        play.play_command(turn["said"], turn.get("thought", ""))
    return play


def _play_command(state: TaskState, play: RecordedGame, command: str) -> str | list[Content]:
    """Play a command, store the episode, and return the game's reply with pictures of the scene."""
    last_reply = _read_last_model_reply()
    reply = play.play_command(command, "" if last_reply == command else last_reply)
    state.store_as(_EpisodeInInspectStore).episode = play.to_json("stopped")
    return make_message_content(Prompt(reply, images=play.draw_pictures_of_current_world()))


def _read_last_model_reply() -> str:
    replies = [event.output for event in transcript().events if isinstance(event, ModelEvent)]
    if not replies or replies[-1].empty:
        return ""
    return "\n\n".join(filter(None, [*find_reasoning(replies[-1]), replies[-1].completion.strip()]))


def _make_tools(state: TaskState, play: RecordedGame) -> list[ToolDef]:
    def make_tool_function(name: str) -> Callable[..., Awaitable[str | list[Content]]]:
        async def call(**arguments: Any) -> str | list[Content]:
            return _play_command(state, play, convert_tool_call_to_command(name, arguments))

        return call

    tools = [
        ToolDef(make_tool_function(name), name, description, ToolParams.model_validate(schema), max_output=0)
        for name, description, schema in list_tool_names_texts_and_schemas(play.setup.domain)
    ]
    return [*tools, *_make_plan_verifier_tools_for_task(state)] if play.setup.rules.verifier else tools


def _make_plan_verifier_tools_for_task(state: TaskState) -> Iterator[ToolDef]:
    """Yield the tools of `eai serve mcp --tools`, which check plans and goals, for the sample's task only."""
    open_tools = load_from_extension("verifier_tools", "agent.verifier")
    task = {"benchmark": str(state.metadata["domain"]), "task": str(state.sample_id)}

    def make_tool_function(name: str) -> Callable[..., Awaitable[str]]:
        async def call(**arguments: Any) -> str:
            tools = open_tools()
            try:
                result: str = await tools.call_tool(name, {**arguments, **task})
            except InputError as error:
                raise ToolError(str(error)) from error
            finally:
                await tools.close()
            return result

        return call

    for name, description, schema in open_tools().list_tool_names_texts_and_schemas():
        properties = {key: value for key, value in schema["properties"].items() if key not in task}
        required = [key for key in schema["required"] if key not in task]
        params = ToolParams.model_validate({**schema, "properties": properties, "required": required})
        yield ToolDef(make_tool_function(name), name, description, params, max_output=0)


@solver(name="eai_enter")
def offer_task_tools() -> Solver:
    """Return a solver that offers the tools of a task to the next solver."""

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        add_epoch_to_metadata(state)
        play = _begin_episode(state)
        if play is not None:
            state.store_as(_EpisodeInInspectStore).episode = play.to_json("stopped")
            state.tools.extend([tool.as_tool() for tool in _make_tools(state, play)])
        return state

    return solve


def _make_solver_that_plays_episode(harness: str | None = None) -> Solver:
    """Return a solver that plays a task with the model: by tools in Inspect's ``react``, or by lines of text.

    Args:
        harness: the program that plays: react, text, auto or module:object; None for the harness that the
            task names.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        setting, play = AgentSetting.from_metadata(state.metadata), _begin_episode(state)
        if play is None:
            state.output = ModelOutput.from_content(str(state.model), DONE)
            return state
        chosen = harness or setting.harness
        agent = AgentState(messages=state.messages)
        limits = [
            turn_limit(_REPLIES_PER_TURN * (play.max_actions + 1)),
            token_limit(setting.tokens),
            time_limit(setting.seconds),
        ]
        with apply_limits(limits, catch_errors=True) as scope:
            if chosen == TEXT:
                await _play_by_text(state, agent, play)
            else:
                await _play_by_tools(state, agent, chosen)
        state.messages = agent.messages
        ended = "stopped" if scope.limit_error is None else _ENDED_BY_LIMIT[scope.limit_error.type]
        _store_episode_and_end_reason_in_state(state, agent.output.stop_reason, ended)
        return state

    return solve


player = solver(name="player")(_make_solver_that_plays_episode)
# in an editable installation, Inspect registers the solver without the prefix "eai/"
if registry_info(player).name == "player":
    player = solver(name="eai/player")(_make_solver_that_plays_episode)


def _store_episode_and_end_reason_in_state(
    state: TaskState, model_stop_reason: StopReason, episode_end_reason: str
) -> None:
    stored = state.store_as(_EpisodeInInspectStore)
    if stored.episode["ended"] == "stopped":
        stored.episode = {**stored.episode, "ended": episode_end_reason}
    state.output = ModelOutput.from_content(str(state.model), read_episode_text(state), model_stop_reason)


async def _play_by_tools(state: TaskState, agent: AgentState, harness: str) -> None:
    """Let the user's agent play, or else let the model call tools.

    The model calls tools until the episode ends or a reply calls no tool. If a reply calls no tool or the
    server refuses tools, the harness ``auto`` asks the model to write later commands as lines of text.
    """
    if harness not in HARNESSES:
        result = await load_object(harness)(state.tools)(agent)
        agent.messages, agent.output = result.messages, result.output
        return

    async def must_continue(agent: AgentState) -> bool:
        is_over = state.store_as(_EpisodeInInspectStore).episode["ended"] in ("done", "steps")
        return bool(agent.output.message.tool_calls) and not is_over

    refusal = ""
    try:
        await react(prompt=None, tools=state.tools, submit=False, on_continue=must_continue)(agent)
    except Exception as error:
        if harness != AUTO or not is_error_about_refused_parameter(error):
            raise
        refusal = f"the server refused tools: {describe_error(error)}"
    play = _begin_episode(state)  # the tool calls have played the episode up to here, and stored its commands
    if play is None or play.is_over or (not refusal and agent.output.message.tool_calls):
        return
    play.without_call = refusal or split_reply(agent.output.completion).answer.strip() or "(an empty reply)"
    state.store_as(_EpisodeInInspectStore).episode = play.to_json("stopped")
    if harness == AUTO:
        agent.messages.append(ChatMessageUser(content=f"You called no tool. {BY_TEXT}"))
        await _play_by_text(state, agent, play)


async def _play_by_text(state: TaskState, agent: AgentState, play: RecordedGame) -> None:
    while not play.is_over:
        agent.output = await get_model().generate(agent.messages)
        if agent.output.empty:
            raise RuntimeError(agent.output.error or "the provider returned no choice")
        agent.messages.append(agent.output.message)
        command = find_command_in_reply(split_reply(agent.output.completion).answer)
        reply = _play_command(state, play, command)
        agent.messages.append(ChatMessageUser(content=reply))


def find_command_in_reply(reply: str) -> str:
    """Return the command of a message: the whole message if it is JSON, else its last line."""
    reply = reply.strip()
    return reply if reply.startswith(("{", "[")) else (reply.splitlines() or [""])[-1].strip()


@solver(name="eai_act")
def play_missing_episodes(run: RunState) -> Solver:
    """Return a solver that plays the episodes that the run lacks, and reports them.

    Unfinished episodes begin anew.
    """
    begin, perform = offer_task_tools(), player()

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        key = (str(state.sample_id), state.epoch)
        recorded = run.open_conversation(key)
        if recorded.answers:
            put_recorded_answer_into_state(state, recorded.answers[-1])
            return state
        if run.stopped is not None:
            return state
        question, request = recorded.conversation.question, run.hash_request_for_next_answer(recorded)
        state.metadata[BEGUN] = run.journal.record_and_count_episode_starts(key, request)
        with report_failure_in_block(run, key):
            state = await perform(await begin(state, generate), generate)
        usage = _sum_usage_of_replies(run.job.endpoint.model)
        run.add_answer(recorded, make_answer(state, request, question, usage))
        return state

    return solve


def _sum_usage_of_replies(model: str) -> AnswerUsage:
    """Return the summed tokens, cost and time of all replies of an episode; built-in models are not timed."""
    replies = [event.output for event in transcript().events if isinstance(event, ModelEvent)]
    seconds = None if is_built_in_model(model) else sum([reply.time or 0.0 for reply in replies])
    return sum(map(read_usage, replies), AnswerUsage(seconds=seconds))
