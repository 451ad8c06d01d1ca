"""Ask a model: one request for a task, and a second one if request options spoilt the answer.

Prompts become messages of Inspect. Replies are repaired: reasoning may stand in the text, a stop sequence may
have cut off the end, and usage figures may be unreadable.
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

from eai.abilities.attempt import AnswerUsage
from eai.abilities.reasoning import split_answer_and_reasoning
from eai.results.trials import Answer, Conversation, ReplanningConversationFactory, TaskIdAndEpoch
from eai.run.context import REMEDIES, describe_long_tasks, find_long_tasks
from eai.run.job import QuestionJob
from eai.run.journal import RunState
from eai.run.request_errors import (
    FINAL_STATUSES,
    UNREADABLE,
    describe_error,
    find_context_length,
    find_http_status,
    is_connection_refused,
    is_library_or_key_missing,
    is_prompt_too_long,
    is_refusal_of_max_tokens,
)
from eai.tasks.prompts.prompt import Prompt


class _ReplyParts(NamedTuple):
    """Answer and reasoning of a reply, with the repairs that separated them.

    Attributes:
        answer: the text without reasoning.
        reasoning: the reasoning without its tags, or empty.
        repairs: names of the repairs, in order.
    """

    answer: str
    reasoning: str
    repairs: tuple[str, ...]


def split_reply(text: str) -> _ReplyParts:
    """Separate the reasoning in a text from the answer; `eai.abilities.reasoning` has the rules."""
    answer, reasoning = split_answer_and_reasoning(text)
    return _ReplyParts(answer, reasoning, ("reasoning",) if answer != text else ())


def restore_brace_cut_off_by_stop_sequence(parts: _ReplyParts, stop: Sequence[str]) -> _ReplyParts:
    """Add the closing brace that a stop sequence cut off; the published answers have this brace."""
    if "}" not in stop or parts.answer.count("{") <= parts.answer.count("}"):
        return parts
    return parts._replace(answer=parts.answer + "}", repairs=(*parts.repairs, "stop_sequence"))


def remove_unreadable_token_usage_in_replies(model: Model) -> Model:
    """Make a model's client remove usage figures that make replies unreadable. Return the model.

    This function changes only clients of OpenAI's protocol, which servers of all kinds speak.
    """
    hooks = getattr(getattr(model.api, "http_client", None), "event_hooks", {}).get("response")
    if hooks is not None and _drop_usage not in hooks:
        client = model.api.http_client  # type: ignore[attr-defined]
        client.event_hooks = {**client.event_hooks, "response": [*hooks, _drop_usage]}
    return model


async def _drop_usage(response: Any) -> None:
    """Remove the usage figures from a response if only these figures make the response unreadable."""
    if "json" not in response.headers.get("content-type", ""):
        return
    try:
        body = json.loads(await response.aread())
        plain = {**body, "usage": None}
    except UNREADABLE:  # the provider's response has no answer
        return
    if not await _is_readable(body) and await _is_readable(plain):
        response._content = json.dumps(plain).encode()


async def _is_readable(body: dict[str, Any]) -> bool:
    from openai.types.chat import ChatCompletion

    try:
        await model_output_from_openai(ChatCompletion.construct(**body))
    except UNREADABLE:
        return False
    return True


def make_messages(prompt: Prompt, metadata: Mapping[str, Any]) -> list[ChatMessage]:
    """Return the messages of a prompt.

    The last message has the metadata of the question, such as the task's id. Only built-in models read it;
    it is not sent to other providers.
    """
    messages: list[ChatMessage] = [ChatMessageUser(content=make_message_content(prompt))]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    for answer, reply in prompt.turns:
        messages += [ChatMessageAssistant(content=answer), ChatMessageUser(content=reply)]
    messages[-1].metadata = dict(metadata)
    return messages


def make_message_content(prompt: Prompt) -> str | list[Content]:
    """Return the content of a message: the text of a prompt, after its pictures if it has any."""
    if not prompt.images:
        return prompt.user
    return [*[ContentImage(image=image.data_url) for image in prompt.images], ContentText(text=prompt.user)]


_REFUSED_PARAMETER_STATUSES = (400, 422)
"""HTTP statuses with which servers refuse a parameter of a request, such as a stop sequence."""

FORM_LEFT_OUT = "form_left_out"
"""Entry of `Answer.repairs`: no schema restricted the answer, because the provider cannot enforce one."""

ANSWERS = "answers"
"""Field of a sample's metadata: the model's answers in order, without reasoning."""


class _ModelReply(NamedTuple):
    """A model's reply: Inspect's output, its answer and reasoning, and its tokens, cost and time."""

    output: ModelOutput
    parts: _ReplyParts
    usage: AnswerUsage


@contextmanager
def report_failure_in_block(run: RunState, key: TaskIdAndEpoch) -> Iterator[None]:
    """Report an error of the `with` block. The run gives up the task, or stops if no request can succeed."""
    run.record_request(key)
    try:
        yield
    except Exception as error:
        is_final = find_http_status(error) in FINAL_STATUSES or is_library_or_key_missing(error)
        if is_final or is_connection_refused(error):
            run.stop_asking_questions(describe_error(error))
        elif (misfits := _describe_tasks_longer_than_context(run, error)) is not None:
            run.stop_asking_questions(misfits)
        elif not is_prompt_too_long(error):
            run.record_failure_and_stop_if_all_failed(key, describe_error(error))
        run.record_failure(*key, describe_error(error))
        raise


def _describe_tasks_longer_than_context(run: RunState, error: Exception) -> str | None:
    """Return one line on the tasks that do not fit into the context that an error names, or None."""
    job, context = run.job, find_context_length(error) if is_prompt_too_long(error) else None
    if context is None or job.pace.too_long != "stop":
        return None
    long_tasks = find_long_tasks(job.suite, job.prompts, job.decoding.max_tokens, context)
    return f"{describe_long_tasks(context, [long_tasks])}, {REMEDIES}" if long_tasks.needs else None


@solver(name="eai_ask")
def make_solver_that_asks_questions(run: RunState) -> Solver:
    """Return a solver that asks a run's unanswered questions.

    The answers are added to the run. The log gets their texts without reasoning.
    """
    restrictions = cache(partial(_make_schema_and_stop_sequence_options, run.job))

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        key = (str(state.sample_id), state.epoch)
        transcript, recorded = _SampleTranscript(state), run.open_conversation(key)
        conversation = recorded.conversation
        for question, answer in zip(conversation.answered_questions, recorded.answers, strict=True):
            transcript.add_question(question, conversation)
            transcript.add_recorded_answer(answer)
        while not conversation.is_over:
            if run.stopped is not None:  # the caller raises this error once, for all samples
                return state
            question, request = conversation.question, run.hash_request_for_next_answer(recorded)
            messages = transcript.add_question(question, conversation)
            with report_failure_in_block(run, key):
                reply = await _ask_within_limit(run, messages, restrictions(key[0], question.stop))
            transcript.add_reply(reply)
            answer = make_answer(state, request, question, reply.usage, transcript.attempt, reply.parts)
            run.add_answer(recorded, answer)
        return state

    return solve


@solver(name="eai_ask_as_published")
def make_solver_without_answer_journal(conversation_factory: ReplanningConversationFactory | None) -> Solver:
    """Return a solver for runs without a journal (file of all answers so far).

    Stop sequences come from the sample's metadata.

    Args:
        conversation_factory: the object that executes answers and asks again after failures; None if each
            question is sent once.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        stop = state.metadata.get("stop")
        restrictions = GenerateConfig(stop_seqs=stop) if stop else None
        transcript = _SampleTranscript(state)
        if conversation_factory is None:
            transcript.add_reply(await _ask_model(state.messages, restrictions))
            return state
        conversation = conversation_factory.start_conversation(str(state.sample_id), state.epoch)
        while not conversation.is_over:
            messages = transcript.add_question(conversation.question, conversation)
            reply = await _ask_model(messages, restrictions)
            transcript.add_reply(reply)
            conversation.add_answer(reply.parts.answer)
        return state

    return solve


def add_epoch_to_metadata(state: TaskState) -> dict[str, Any]:
    """Add the epoch (round of answers) to a question's metadata for built-in models. Return the metadata."""
    metadata = {**(state.messages[-1].metadata or {}), "epoch": state.epoch}
    state.messages[-1].metadata = metadata
    return metadata


class _SampleTranscript:
    """The conversation with a model about one sample, kept in the sample's state and metadata.

    Attributes:
        attempt: number of questions so far; each question begins an attempt at the task.
    """

    def __init__(self, state: TaskState) -> None:
        self.attempt = 0
        self._state = state
        self._metadata = add_epoch_to_metadata(state)

    def add_question(self, question: Prompt, conversation: Conversation) -> list[ChatMessage]:
        """Add a question to the state: all messages of the first question, the last message of later ones.

        Returns:
            the messages to send. The last message has metadata: the number of the attempt, and the actions of
                earlier attempts that changed the world in which this attempt starts.
        """
        self.attempt += 1
        actions = [[action.operator, *action.arguments] for action in conversation.executed_actions]
        metadata = {"attempt": self.attempt, "done": actions}
        messages = make_messages(
            question, {**self._metadata, **conversation.changed_scene_metadata_of_next_question, **metadata}
        )
        if self.attempt == 1:
            self._state.messages = list(messages)
        else:
            self._state.messages.append(messages[-1])
            self._state.output = ModelOutput(
                model=str(self._state.model)
            )  # the last answer is no answer to the new question
        return messages

    def add_recorded_answer(self, answer: Answer) -> None:
        """Add an answer from an earlier start of the run to the state of the sample."""
        put_recorded_answer_into_state(self._state, answer)
        self._store_answer_text(answer.text)

    def add_reply(self, reply: _ModelReply) -> None:
        """Add a reply to the state: the message as it came, and the answer without reasoning."""
        self._state.messages.append(reply.output.message)
        self._state.output = reply.output
        self._state.output.completion = reply.parts.answer
        self._store_answer_text(reply.parts.answer)

    def _store_answer_text(self, text: str) -> None:
        self._state.metadata[ANSWERS] = [*self._state.metadata.get(ANSWERS, ()), text]


def put_recorded_answer_into_state(state: TaskState, answer: Answer) -> None:
    """Put a recorded answer into the state of a sample, as if the model had just replied."""
    content: list[Content] = [ContentReasoning(reasoning=answer.reasoning)] if answer.reasoning else []
    message = ChatMessageAssistant(
        content=[*content, ContentText(text=answer.text)], model=str(state.model), source="generate"
    )
    state.messages.append(message)
    state.output = ModelOutput.from_message(message, cast(StopReason, answer.stop_reason))


def make_answer(
    state: TaskState,
    request_sha256: str,
    prompt: Prompt,
    usage: AnswerUsage,
    attempt: int = 1,
    parts: _ReplyParts | None = None,
) -> Answer:
    """Return the answer in a sample's state, for the journal (file of all answers so far).

    ``parts`` has the reasoning of the answer, and the names of the corrections of its text.
    """
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


def _make_schema_and_stop_sequence_options(
    job: QuestionJob, task_id: str, stop: tuple[str, ...]
) -> GenerateConfig | None:
    """Return the options for a schema and stop sequences, which only some models support, or None."""
    schema = job.make_answer_schema(task_id)
    stop = stop if job.decoding.stop else ()
    if not stop and schema is None:
        return None
    response_schema = None
    if schema is not None:
        response_schema = ResponseSchema(
            name="answer", json_schema=JSONSchema.model_validate(schema), strict=True
        )
    return GenerateConfig(stop_seqs=list(stop) or None, response_schema=response_schema)


async def _ask_within_limit(
    run: RunState, messages: list[ChatMessage], restrictions: GenerateConfig | None
) -> _ModelReply:
    """Ask a model for an answer of limited length. Ask again without the limit if the limit is unsuitable.

    It is unsuitable if question and limit together exceed the model's context, if the server allows only
    shorter answers, or if the model reasons. In the last two cases, the run sends no limit from then on.
    """
    first_usage, limit = AnswerUsage(), run.answer_limit
    if limit is not None:
        try:
            reply = await _ask_model(messages, restrictions, limit)
            reasons = bool(reply.parts.reasoning or reply.usage.reasoning_tokens)
            run.answer_limit = None if reasons else run.answer_limit
            if not reasons or reply.output.stop_reason != "max_tokens":
                return reply
            first_usage = reply.usage
        except Exception as error:
            if not is_prompt_too_long(error):
                if not is_refusal_of_max_tokens(error):
                    raise
                run.answer_limit = None
    output, parts, usage = await _ask_model(messages, restrictions)
    return _ModelReply(output, parts, first_usage + usage)


async def _ask_model(
    messages: list[ChatMessage], restrictions: GenerateConfig | None, max_tokens: int | None = None
) -> _ModelReply:
    """Ask a model. Ask again without restrictions if the provider refused them or they left no answer.

    Restrictions are stop sequences and a schema. A stop sequence may stand in the middle of reasoning, and
    some servers return nothing for a schema that they do not support.
    """
    unrestricted = GenerateConfig(max_tokens=max_tokens)
    if restrictions is None:
        return await _send_request(messages, unrestricted)
    first_usage = AnswerUsage()
    try:
        reply = await _send_request(messages, restrictions.merge(unrestricted))
        if reply.parts.answer.strip() or reply.output.stop_reason != "stop":
            return reply
        first_usage = reply.usage
    except Exception as error:
        if not is_error_about_refused_parameter(error):
            raise
    output, parts, usage = await _send_request(messages, unrestricted)
    if restrictions.response_schema is not None:
        parts = parts._replace(repairs=(FORM_LEFT_OUT, *parts.repairs))
    return _ModelReply(output, parts, first_usage + usage)


def is_error_about_refused_parameter(error: BaseException) -> bool:
    """Whether a server refused a request because of a parameter that it does not support."""
    return find_http_status(error) in _REFUSED_PARAMETER_STATUSES and not is_prompt_too_long(error)


async def _send_request(messages: list[ChatMessage], restrictions: GenerateConfig) -> _ModelReply:
    output = await get_model().generate(messages, config=restrictions)
    if output.empty:
        raise RuntimeError(output.error or "the provider returned no choice")
    if output.stop_reason == "model_length" and output.usage is None:  # the provider refused the question
        raise RuntimeError(f"the question is too long for the model's context: {output.completion}")
    return _ModelReply(
        output, _split_output_into_parts(output, restrictions.stop_seqs or ()), read_usage(output)
    )


def _split_output_into_parts(output: ModelOutput, stop: Sequence[str]) -> _ReplyParts:
    parts = split_reply(output.completion)
    if output.stop_reason == "stop":
        parts = restore_brace_cut_off_by_stop_sequence(parts, stop)
    return parts._replace(reasoning="\n\n".join(filter(None, [*find_reasoning(output), parts.reasoning])))


def find_reasoning(output: ModelOutput) -> list[str]:
    """Return the blocks of reasoning in a reply. An encrypted block is replaced by its summary."""
    content = output.message.content
    blocks = [] if isinstance(content, str) else [c for c in content if isinstance(c, ContentReasoning)]
    return [block.summary or "" if block.redacted else block.reasoning for block in blocks]


def read_usage(output: ModelOutput) -> AnswerUsage:
    """Return the usage of a reply, with None for unknown numbers.

    The library Inspect reports zeros if a provider counts nothing. Every question has
    tokens, so without input tokens, zeros mean unknown numbers. If a number is negative, all are unknown.
    """
    usage = output.usage
    if usage is None:
        return AnswerUsage()
    cached = (usage.input_tokens_cache_read or 0) + (usage.input_tokens_cache_write or 0)
    input_tokens, output_tokens = usage.input_tokens + cached, usage.output_tokens
    counts = (input_tokens, output_tokens, usage.reasoning_tokens, usage.total_cost)
    if min(number or 0 for number in counts) < 0:
        return AnswerUsage()
    if not input_tokens:
        return AnswerUsage(None, output_tokens or None, usage.reasoning_tokens or None, usage.total_cost)
    return AnswerUsage(*counts)
