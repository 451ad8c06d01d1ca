"""Questions as the messages that a model is sent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from inspect_ai.model import ChatMessage, ChatMessageAssistant, ChatMessageSystem, ChatMessageUser

from eai.prompts.prompt import Prompt

QUESTION = "question"
"""The field of a message's metadata that has the world-model question that it asks."""

STATED = "stated"
"""The field of a message's metadata that has the answer whose goals it states in the place of the task's."""


def messages_of(prompt: Prompt, about: Mapping[str, Any]) -> list[ChatMessage]:
    """The messages of a prompt.

    The last of them says what it is about: built-in models read it there. From other models the metadata
    stays at home.
    """
    messages: list[ChatMessage] = [ChatMessageUser(content=prompt.user)]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    for turn in prompt.turns:
        messages += [ChatMessageAssistant(content=turn.answer), ChatMessageUser(content=turn.reply)]
    messages[-1].metadata = dict(about)
    return messages
