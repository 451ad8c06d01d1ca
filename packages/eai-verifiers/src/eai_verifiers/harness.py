"""A harness that asks the model in this process: no sandbox, no extra program, one request per turn."""

from __future__ import annotations

from typing import Any

import httpx
import verifiers.v1 as vf
from verifiers.v1.dialects.chat import message_to_wire
from verifiers.v1.types import UserMessage


class InProcessHarnessConfig(vf.HarnessConfig):
    """Configuration of the harness, which has no options."""


class InProcessHarness(vf.Harness[InProcessHarnessConfig]):
    """Asks the model once for each turn of the user, without tools.

    The stock harness starts a program for each rollout. That takes about a hundred times as long as the
    verdict.
    """

    APPENDS_SYSTEM_PROMPT = True
    SUPPORTS_RESUME = True
    EXECUTES_CODE = False
    NEEDS_CONTAINER = False

    async def launch(
        self,
        ctx: vf.ModelContext,
        trace: vf.Trace,
        runtime: vf.Runtime,
        endpoint: str,
        secret: str,
        mcp_urls: dict[str, str],
        data: vf.TaskData,
        tool_interception_url: str | None = None,
    ) -> vf.ProgramResult:
        """Ask the model to continue the conversation."""
        system, prompt = self.resolve_prompt(data)
        messages = [UserMessage(content=prompt)] if isinstance(prompt, str) else prompt or []
        messages_to_send: list[dict[str, Any]] = [message_to_wire(message) for message in messages]
        if system is not None:
            messages_to_send.insert(0, {"role": "system", "content": system})
        # A server on this machine needs no certificates, and loading them takes longer than all the rest.
        async with httpx.AsyncClient(timeout=None, verify=endpoint.startswith("https:")) as client:  # noqa: S113
            reply = await client.post(
                f"{endpoint}/chat/completions",
                json={"model": ctx.model, "messages": messages_to_send},
                headers={"Authorization": f"Bearer {secret}"},
            )
        return vf.ProgramResult(0 if reply.is_success else 1, "", "" if reply.is_success else reply.text)
