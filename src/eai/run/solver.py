"""Asking a model: one request a task, or two where the first was corrupted by how it was made.

Prompts become messages, and replies are taken apart: reasoning may stand in the text, a stop sequence may
have cut off its end, and its figures of usage may be unreadable.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from typing import Any, NamedTuple, cast

from inspect_ai.model import (
    ChatMessage,
    ChatMessageAssistant,
    ChatMessageSystem,
    ChatMessageUser,
    Content,
    ContentImage,
    ContentReasoning,
    ContentText,
    GenerateConfig,
    Model,
    ModelOutput,
    ResponseSchema,
    StopReason,
    get_model,
    model_output_from_openai,
)
from inspect_ai.solver import Generate, Solver, TaskState, solver
from inspect_ai.util import JSONSchema
from tenacity import RetryError

from eai.abilities.attempt import Usage
from eai.abilities.reasoning import split_reasoning
from eai.results.trials import Answer, AnswerKey, Conversation, Trials
from eai.run.job import Job
from eai.run.journal import RunState
from eai.tasks.prompts.prompt import Prompt


class _ReplyParts(NamedTuple):
    """The parts of a reply, and the repairs that parting it took.

    Attributes:
        answer: the text without reasoning.
        reasoning: the reasoning without its tags, or empty.
        repairs: names of what was done, in order.
    """

    answer: str
    reasoning: str
    repairs: tuple[str, ...]


def split_reply(text: str) -> _ReplyParts:
    """Separate the reasoning in a text from the answer (`eai.abilities.reasoning`)."""
    answer, reasoning = split_reasoning(text)
    return _ReplyParts(answer, reasoning, ("reasoning",) if answer != text else ())


def restore_brace(parts: _ReplyParts, stop: Sequence[str]) -> _ReplyParts:
    """Give back the closing brace that a stop sequence took away, as the published answers have it."""
    if "}" not in stop or parts.answer.count("{") <= parts.answer.count("}"):
        return parts
    return parts._replace(answer=parts.answer + "}", repairs=(*parts.repairs, "stop_sequence"))


UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""The errors that providers' libraries raise where a reply has not the form that they expect."""


def drop_unreadable_usage(model: Model) -> Model:
    """The model, whose client from now on leaves usage that cannot be read out of what a server replies.

    It is for those that speak OpenAI's protocol, as servers of all kinds do.
    """
    hooks = getattr(getattr(model.api, "http_client", None), "event_hooks", {}).get("response")
    if hooks is not None and _drop_usage not in hooks:
        client = model.api.http_client  # type: ignore[attr-defined]
        client.event_hooks = {**client.event_hooks, "response": [*hooks, _drop_usage]}
    return model


async def _drop_usage(response: Any) -> None:
    """Leave usage out of a response of the client's library, if nothing but usage cannot be read in it."""
    if "json" not in response.headers.get("content-type", ""):
        return
    try:
        body = json.loads(await response.aread())
        plain = {**body, "usage": None}
    except UNREADABLE:  # no answer at all
        return
    if not await _is_readable(body) and await _is_readable(plain):
        response._content = json.dumps(plain).encode()


async def _is_readable(body: dict[str, Any]) -> bool:
    """Whether Inspect can read a reply."""
    from openai.types.chat import ChatCompletion

    try:
        await model_output_from_openai(ChatCompletion.construct(**body))
    except UNREADABLE:
        return False
    return True


def messages_of(prompt: Prompt, about: Mapping[str, Any]) -> list[ChatMessage]:
    """The messages of a prompt.

    The last of them says what it is about: built-in models read it there. From other models the metadata
    stays at home.
    """
    messages: list[ChatMessage] = [ChatMessageUser(content=content_of(prompt))]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    for answer, reply in prompt.turns:
        messages += [ChatMessageAssistant(content=answer), ChatMessageUser(content=reply)]
    messages[-1].metadata = dict(about)
    return messages


def content_of(prompt: Prompt) -> str | list[Content]:
    """The text of a prompt, after its pictures if it has any."""
    if not prompt.images:
        return prompt.user
    return [*[ContentImage(image=image.url) for image in prompt.images], ContentText(text=prompt.user)]


_REFUSED_PARAMETERS = (400, 422)
"""The HTTP statuses with which servers answer to parameters that they do not take."""

FINAL = (401, 404)
"""The HTTP statuses that no repetition changes: a key that is wrong, a model that is unknown."""

FORM_LEFT_OUT = "form_left_out"
"""The repair that answers name where it was to be held to a form and could not be."""

ANSWERS = "answers"
"""The field of a sample's metadata that has the answers to it, in order, without reasoning."""


class _Reply(NamedTuple):
    """The reply of a model."""

    output: ModelOutput
    parts: _ReplyParts
    usage: Usage


@contextmanager
def report_failure(desk: RunState, place: AnswerKey) -> Iterator[None]:
    """Tells the desk of an error in the block: the task is given up, or the run where nothing else helps."""
    try:
        yield
    except Exception as error:
        if http_status(error) in FINAL:
            desk.stop(describe_error(error))
        desk.give_up(*place, describe_error(error))
        raise


@solver(name="eai_ask")
def ask(desk: RunState) -> Solver:
    """Asks what is not answered yet; answers go to the desk, and their text without reasoning to the log."""
    restrictions = cache(partial(_restrictions, desk.job))

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        place = (str(state.sample_id), state.epoch)
        transcript, inquiry = _Transcript(state), desk.conversations[place]
        for question, answer in zip(inquiry.asked, desk.all_answers[place], strict=True):
            transcript.ask(question, inquiry)
            transcript.remember(answer)
        while not inquiry.is_over:
            if desk.stopped is not None:  # the run ends with that; a traceback for each sample takes long
                return state
            question, request = inquiry.question, desk.request(place)
            messages = transcript.ask(question, inquiry)
            with report_failure(desk, place):
                reply = await _ask_model(messages, restrictions(place[0], question.stop))
            transcript.hear(reply)
            desk.add_answer(
                make_answer(state, request, question, reply.usage, transcript.attempt, reply.parts)
            )
        return state

    return solve


@solver(name="eai_ask_as_published")
def ask_as_published(trials: Trials | None) -> Solver:
    """Asks with the stop sequences of the sample's metadata; for runs without a desk.

    Args:
        trials: how answers are carried out in an experiment; None where each question is asked once.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        stop = state.metadata.get("stop")
        restrictions = GenerateConfig(stop_seqs=stop) if stop else None
        transcript = _Transcript(state)
        if trials is None:
            transcript.hear(await _ask_model(state.messages, restrictions))
            return state
        inquiry = trials.start_conversation(str(state.sample_id), state.epoch)
        while not inquiry.is_over:
            messages = transcript.ask(inquiry.question, inquiry)
            reply = await _ask_model(messages, restrictions)
            transcript.hear(reply)
            inquiry.add_answer(reply.parts.answer)
        return state

    return solve


def add_epoch(state: TaskState) -> dict[str, Any]:
    """The metadata of the question of a sample, which from now on say its epoch, for the built-in models."""
    about = {**(state.messages[-1].metadata or {}), "epoch": state.epoch}
    state.messages[-1].metadata = about
    return about


class _Transcript:
    """Questions and answers, in the state of a sample, whose metadata has the bare answers.

    Attributes:
        attempt: which attempt at the task the last question is for.
    """

    def __init__(self, state: TaskState) -> None:
        self.attempt = 0
        self._state = state
        self._about = add_epoch(state)

    def ask(self, question: Prompt, inquiry: Conversation) -> list[ChatMessage]:
        """Write a question down: all of the first, then what is new.

        Returns:
            the messages to send. The last says the attempt, and what has been done in a world that continues.
        """
        self.attempt += 1
        done = [[action.operator, *action.arguments] for action in inquiry.executed_actions]
        now = {"attempt": self.attempt, "done": done}
        messages = messages_of(question, {**self._about, **inquiry.metadata, **now})
        if self.attempt == 1:
            self._state.messages = list(messages)
        else:
            self._state.messages.append(messages[-1])
            self._state.output = ModelOutput(model=str(self._state.model))  # none, unless it is answered
        return messages

    def remember(self, answer: Answer) -> None:
        """Write down an answer that was given before."""
        restore_answer(self._state, answer)
        self._keep(answer.text)

    def hear(self, reply: _Reply) -> None:
        """Write a reply down: the message as it came, the answer without reasoning."""
        self._state.messages.append(reply.output.message)
        self._state.output = reply.output
        self._state.output.completion = reply.parts.answer
        self._keep(reply.parts.answer)

    def _keep(self, text: str) -> None:
        self._state.metadata[ANSWERS] = [*self._state.metadata.get(ANSWERS, ()), text]


def restore_answer(state: TaskState, answer: Answer) -> None:
    """Bring a state to what it was after a reply that was written down before."""
    content: list[Content] = [ContentReasoning(reasoning=answer.reasoning)] if answer.reasoning else []
    message = ChatMessageAssistant(
        content=[*content, ContentText(text=answer.text)], model=str(state.model), source="generate"
    )
    state.messages.append(message)
    state.output = ModelOutput.from_message(message, cast(StopReason, answer.stop_reason))


def describe_error(error: BaseException) -> str:
    """Why a request failed, in one line; of one that was repeated, why its last attempt did."""
    error = _last(error)
    lines = str(error).strip().splitlines()
    first = f"{type(error).__name__}: {lines[0].strip()}" if lines else type(error).__name__
    if isinstance(error, UNREADABLE):
        return f"the provider's reply cannot be read ({first if lines else 'it is no completion'})"
    return first


def _last(error: BaseException) -> BaseException:
    """The provider's error: of a request that was repeated without success, that of its last attempt."""
    if isinstance(error, RetryError | RuntimeError) and error.__cause__ is not None:
        return error.__cause__
    return error


def http_status(error: BaseException) -> int | None:
    """The HTTP status with which a request failed, if it is known."""
    status = getattr(_last(error), "status_code", None)
    return status if isinstance(status, int) else None


def make_answer(
    state: TaskState,
    request_sha256: str,
    prompt: Prompt,
    usage: Usage,
    attempt: int = 1,
    parts: _ReplyParts | None = None,
) -> Answer:
    """The answer that a state has come to, as the journal keeps it; ``parts`` has what was parted from it."""
    return Answer(
        task_id=str(state.sample_id),
        epoch=state.epoch,
        request_sha256=request_sha256,
        prompt_sha256=prompt.sha256,
        text=state.output.completion,
        reasoning=parts.reasoning if parts else "",
        stop_reason=state.output.stop_reason,
        repairs=parts.repairs if parts else (),
        usage=usage,
        attempt=attempt,
    )


def _restrictions(job: Job, task_id: str, stop: tuple[str, ...]) -> GenerateConfig | None:
    """The parts of a request that not every model takes: stop sequences and a form of the answer."""
    form = job.answer_schema(task_id)
    stop = stop if job.decoding.stop else ()
    if not stop and form is None:
        return None
    schema = None
    if form is not None:
        schema = ResponseSchema(name="answer", json_schema=JSONSchema.model_validate(form), strict=True)
    return GenerateConfig(stop_seqs=list(stop) or None, response_schema=schema)


async def _ask_model(messages: list[ChatMessage], restrictions: GenerateConfig | None) -> _Reply:
    """Ask once; and once more without restrictions where they were refused, or left nothing of the answer.

    A stop sequence may stand in the middle of reasoning, and some servers return nothing for a form that
    they do not know.
    """
    if restrictions is None:
        return await _request(messages, GenerateConfig())
    spent = Usage()
    try:
        reply = await _request(messages, restrictions)
        if reply.parts.answer.strip() or reply.output.stop_reason != "stop":
            return reply
        spent = reply.usage
    except Exception as error:
        if http_status(error) not in _REFUSED_PARAMETERS:
            raise
    output, parts, usage = await _request(messages, GenerateConfig())
    if restrictions.response_schema is not None:
        parts = parts._replace(repairs=(FORM_LEFT_OUT, *parts.repairs))
    return _Reply(output, parts, spent + usage)


async def _request(messages: list[ChatMessage], restrictions: GenerateConfig) -> _Reply:
    output = await get_model().generate(messages, config=restrictions)
    if output.empty:
        raise RuntimeError(output.error or "the provider returned no choice")
    if output.stop_reason == "model_length" and output.usage is None:  # nothing was written: it is refused
        raise RuntimeError(f"the question is too long: {output.completion}")
    return _Reply(output, _parts(output, restrictions.stop_seqs or ()), usage_of(output))


def _parts(output: ModelOutput, stop: Sequence[str]) -> _ReplyParts:
    parts = split_reply(output.completion)
    if output.stop_reason == "stop":
        parts = restore_brace(parts, stop)
    return parts._replace(reasoning="\n\n".join(filter(None, [*find_reasoning(output), parts.reasoning])))


def find_reasoning(output: ModelOutput) -> list[str]:
    """The reasoning beside the text of a reply, block by block; of what is kept secret its summary."""
    content = output.message.content
    blocks = [] if isinstance(content, str) else [c for c in content if isinstance(c, ContentReasoning)]
    return [block.summary or "" if block.redacted else block.reasoning for block in blocks]


def usage_of(output: ModelOutput) -> Usage:
    """Return the usage of a reply, in which unknown numbers are None.

    Inspect has zeros if a provider counts nothing; no question has no tokens. Negative numbers are unknown.
    """
    usage = output.usage
    if usage is None:
        return Usage()
    cached = (usage.input_tokens_cache_read or 0) + (usage.input_tokens_cache_write or 0)
    asked, answered = usage.input_tokens + cached, usage.output_tokens
    counted = (asked, answered, usage.reasoning_tokens, usage.total_cost)
    if min(number or 0 for number in counted) < 0:
        return Usage()
    if not asked:
        return Usage(None, answered or None, usage.reasoning_tokens or None, usage.total_cost)
    return Usage(*counted)
