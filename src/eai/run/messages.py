"""Questions as the messages that a model is sent, and its replies taken apart.

Reasoning may stand in the text of a reply, and a stop sequence may have cut off its end. A reply whose
figures of usage cannot be read is an answer all the same.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from inspect_ai.model import (
    ChatMessage,
    ChatMessageAssistant,
    ChatMessageSystem,
    ChatMessageUser,
    Content,
    ContentImage,
    ContentText,
    Model,
    model_output_from_openai,
)

from eai.prompts.prompt import Image, Prompt

_OPEN, _CLOSE = "<think>", "</think>"


class Parts(NamedTuple):
    """The parts of a reply, and the repairs that parting it took.

    Attributes:
        answer: the text without reasoning.
        reasoning: the reasoning without its tags, or empty.
        repairs: names of what was done, in order.
    """

    answer: str
    reasoning: str
    repairs: tuple[str, ...]


def part(text: str) -> Parts:
    """Separate reasoning between ``<think>`` tags.

    The opening tag may be missing, since many chat templates put it into the question. If the closing one is
    missing behind an opening one, all of the text is reasoning and there is no answer.
    """
    reasoning, closed, answer = text.rpartition(_CLOSE)
    if closed:
        return Parts(answer.strip(), reasoning.replace(_OPEN, "", 1).strip(), ("reasoning",))
    if text.lstrip().startswith(_OPEN):
        return Parts("", text.lstrip().removeprefix(_OPEN).strip(), ("reasoning",))
    return Parts(text, "", ())


def complete(parts: Parts, stop: Sequence[str]) -> Parts:
    """Give back the closing brace that a stop sequence took away, as the published answers have it."""
    if "}" not in stop or parts.answer.count("{") <= parts.answer.count("}"):
        return parts
    return parts._replace(answer=parts.answer + "}", repairs=(*parts.repairs, "stop_sequence"))


UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""The errors that providers' libraries raise where a reply has not the form that they expect."""


def without_odd_usage(model: Model) -> Model:
    """The model, whose client from now on leaves usage that cannot be read out of what a server replies.

    It is for those that speak OpenAI's protocol, as servers of all kinds do.
    """
    hooks = getattr(getattr(model.api, "http_client", None), "event_hooks", {}).get("response")
    if hooks is not None and _leave_out not in hooks:
        client = model.api.http_client  # type: ignore[attr-defined]
        client.event_hooks = {**client.event_hooks, "response": [*hooks, _leave_out]}
    return model


async def _leave_out(response: Any) -> None:
    """Leave usage out of a response of the client's library, if nothing but usage cannot be read in it."""
    if "json" not in response.headers.get("content-type", ""):
        return
    try:
        body = json.loads(await response.aread())
        usage = body.pop("usage")
        plain = {**body, "usage": None}
        await _read(plain)
    except UNREADABLE:  # no answer at all, or no usage
        return
    try:
        await _read({**body, "usage": usage})
    except UNREADABLE:
        response._content = json.dumps(plain).encode()


async def _read(body: dict[str, Any]) -> None:
    """Read a reply as Inspect does.

    Raises:
        Exception: one of `UNREADABLE`.
    """
    from openai.types.chat import ChatCompletion

    await model_output_from_openai(ChatCompletion.construct(**body))


ERRATA = "errata"
"""The field that says whether the task's own answers are the corrected ones."""


def messages_of(prompt: Prompt, about: Mapping[str, Any]) -> list[ChatMessage]:
    """The messages of a prompt.

    The last of them says what it is about: built-in models read it there. From other models the metadata
    stays at home.
    """
    messages: list[ChatMessage] = [ChatMessageUser(content=_content(prompt))]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    for turn in prompt.turns:
        messages += [ChatMessageAssistant(content=turn.answer), ChatMessageUser(content=turn.reply)]
    messages[-1].metadata = dict(about)
    return messages


def _content(prompt: Prompt) -> str | list[Content]:
    """The question, after its pictures if it has any."""
    if not prompt.images:
        return prompt.user
    return [*[ContentImage(image=_url(image)) for image in prompt.images], ContentText(text=prompt.user)]


def _url(image: Image) -> str:
    """A picture as Inspect hands it to any provider."""
    return f"data:{image.media_type};base64,{base64.b64encode(image.data).decode()}"
