"""Replies whose figures of usage cannot be read: they are answers all the same."""

from __future__ import annotations

import json
from typing import Any

from inspect_ai.model import Model, model_output_from_openai

UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""What providers' libraries raise where a reply has not the form that they expect."""


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
