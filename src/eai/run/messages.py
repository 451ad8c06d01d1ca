"""Questions as the messages that a model is sent."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

from inspect_ai.model import (
    ChatMessage,
    ChatMessageAssistant,
    ChatMessageSystem,
    ChatMessageUser,
    Content,
    ContentImage,
    ContentText,
)

from eai.prompts.prompt import Image, Prompt

QUESTION = "question"
"""The field of a message's metadata that has the world-model question that it asks."""

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
