"""Serve worlds over the Model Context Protocol: agents act by tool calls, over standard input or HTTP.

Over standard input the process serves one world. Over HTTP every request carries a ticket, a secret that
identifies one episode, because the protocol has no sessions. The server has no other route than the
protocol's.
"""

from __future__ import annotations

import asyncio
import base64
import logging
import os
import signal
import socket
import sys
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

import uvicorn
from mcp import MCPError
from mcp.server.auth.middleware.bearer_auth import AuthenticatedUser
from mcp.server.auth.provider import AccessToken
from mcp.server.auth.settings import AuthSettings
from mcp.server.context import ServerRequestContext
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp.server.transport_security import TransportSecuritySettings
from mcp.types import (
    INTERNAL_ERROR,
    CallToolRequestParams,
    CallToolResult,
    ImageContent,
    ListToolsResult,
    TextContent,
    Tool,
)
from pydantic import AnyHttpUrl
from starlette.applications import Starlette

from eai import __version__
from eai.abilities.scorer import describe_exception
from eai.agents.episode_server import EpisodeServer
from eai.agents.tools import convert_tool_call_to_command, list_tool_names_texts_and_schemas
from eai.base.errors import EaiError, InputError
from eai.tasks.prompts.prompt import Image
from eai.world.domain import Domain

MAX_BODY = 65_536
"""Maximum size of a request, in bytes."""

MAX_COMMAND = 2_000
"""Maximum length of a command in a tool call, in characters."""

_MAX_CONNECTIONS = 1_000

_LOG = logging.getLogger(__name__)

_HOW = "You act in a simulated world. Call look to read your task, act for each action, and done at the end."


class _ServedTools(Protocol):
    """Tools that a server offers without an episode. Each call is independent of all other calls.

    Attributes:
        instructions: text for the model that may call the tools.
    """

    instructions: str

    def list_tool_names_texts_and_schemas(self) -> Sequence[tuple[str, str, Mapping[str, Any]]]:
        """Return the tools: name, description, and JSON schema of the arguments."""

    async def call_tool(self, name: str, arguments: Mapping[str, object]) -> str:
        """Return the result of a tool call. Raises InputError if the call is invalid or exceeds a limit."""

    async def close(self) -> None:
        """End all processes that answer tool calls."""


class _EpisodeTokenVerifier:
    """Verifies the access tokens (tickets) of requests: each must belong to an episode."""

    def __init__(self, worlds: EpisodeServer) -> None:
        self._worlds = worlds

    async def verify_token(self, token: str) -> AccessToken | None:
        return AccessToken(token=token, client_id=token, scopes=[]) if token in self._worlds.tickets else None


def make_mcp_server(
    episodes: EpisodeServer, domain: Domain, *, all_share_first_episode: bool = True
) -> Server[Any]:
    """Return a server through which agents act in the worlds of episodes.

    Args:
        episodes: the episodes, each with its world.
        domain: the domain of all worlds.
        all_share_first_episode: whether all callers act in the first world; otherwise each caller acts in
            the world of the caller's ticket.
    """

    async def call_tool(context: ServerRequestContext[Any], params: CallToolRequestParams) -> CallToolResult:
        key = (
            episodes.episode_keys[0]
            if all_share_first_episode
            else episodes.tickets[_get_access_token_of_request(context)]
        )
        try:
            command = convert_tool_call_to_command(params.name, params.arguments or {})
            if len(command) > MAX_COMMAND:
                raise InputError(f"the command is too long: give at most {MAX_COMMAND:,} characters")
        except InputError as error:
            return _make_error_result(error)
        try:
            told = TextContent(text=episodes.play_command(key, command))
            return CallToolResult(
                content=[told, *map(_encode_image, episodes.draw_pictures_of_current_world(key))]
            )
        except Exception as error:  # the message names files, which the agent must not know
            _LOG.error("%s", error if isinstance(error, EaiError) else describe_exception(error))
            raise MCPError(INTERNAL_ERROR, "the world is out of order") from None

    return _make_server(_HOW, list_tool_names_texts_and_schemas(domain), call_tool)


def make_tool_server(tools: _ServedTools) -> Server[Any]:
    """Return an MCP server whose tools can be called outside episodes."""

    async def call_tool(context: object, params: CallToolRequestParams) -> CallToolResult:
        try:
            text = await tools.call_tool(params.name, params.arguments or {})
        except InputError as error:
            return _make_error_result(error)
        return CallToolResult(content=[TextContent(text=text)])

    return _make_server(tools.instructions, tools.list_tool_names_texts_and_schemas(), call_tool)


def _make_server(
    instructions: str,
    tools: Sequence[tuple[str, str, Mapping[str, Any]]],
    call_tool: Callable[[ServerRequestContext[Any], CallToolRequestParams], Awaitable[CallToolResult]],
) -> Server[Any]:
    listed = ListToolsResult(
        tools=[
            Tool(name=name, description=meaning, input_schema={**schema}) for name, meaning, schema in tools
        ]
    )

    async def list_tools(context: object, params: object) -> ListToolsResult:
        return listed

    return Server(
        "eai",
        version=__version__,
        instructions=instructions,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


def _make_error_result(error: InputError) -> CallToolResult:
    return CallToolResult(content=[TextContent(text=str(error))], is_error=True)


def _encode_image(image: Image) -> ImageContent:
    return ImageContent(data=base64.b64encode(image.data).decode(), mime_type=image.media_type)


def _get_access_token_of_request(context: ServerRequestContext[Any]) -> str:
    user = None if context.request is None else context.request.user
    if not isinstance(user, AuthenticatedUser):
        raise MCPError(INTERNAL_ERROR, "a request without a ticket was let in")
    return user.access_token.token


def serve_stdio(episodes: EpisodeServer, domain: Domain) -> None:
    """Serve the world of the first episode over standard input and output, until the input ends."""
    run = partial(_run_over_stdio, make_mcp_server(episodes, domain), episodes.close)
    asyncio.run(_run_until_done(episodes, run))


def serve_tools_over_stdio(tools: _ServedTools) -> None:
    """Serve tools without an episode over standard input and output, until the input ends."""

    async def run() -> None:
        try:
            await _run_over_stdio(make_tool_server(tools), lambda: None)
        finally:
            await tools.close()

    asyncio.run(run())


async def _run_over_stdio(server: Server[Any], close: Callable[[], None]) -> None:
    def exit_on_signal(signal_number: int) -> None:
        close()
        os._exit(128 + signal_number)  # a normal exit would wait for the thread that reads standard input

    if sys.platform != "win32":
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, exit_on_signal, number)
    async with stdio_server() as (read, write):
        await server.run(read, write, server.create_initialization_options())


def make_http_app(
    episodes: EpisodeServer,
    domain: Domain,
    host_names: Sequence[str],
    *,
    all_share_first_episode: bool = False,
) -> Starlette:
    """Return the application that serves worlds over streamable HTTP at ``/mcp``.

    Args:
        episodes: the episodes, each with its world.
        domain: the domain of all worlds.
        host_names: host names by which requests may call the application. Requests with another host name,
            and requests of web pages, are refused.
        all_share_first_episode: whether all callers act in the first world, without a ticket (the secret
            that selects an episode).
    """
    hosts = [text for name in host_names for text in (name, f"{name}:*")]
    issuer = AnyHttpUrl("http://localhost")  # AuthSettings requires a URL, but no tokens are issued at it
    return make_mcp_server(
        episodes, domain, all_share_first_episode=all_share_first_episode
    ).streamable_http_app(
        json_response=True,
        stateless_http=True,
        max_request_body_size=MAX_BODY,
        transport_security=TransportSecuritySettings(allowed_hosts=hosts),
        auth=None if all_share_first_episode else AuthSettings(issuer_url=issuer, resource_server_url=None),
        token_verifier=None if all_share_first_episode else _EpisodeTokenVerifier(episodes),
    )


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens at an address.

    Raises:
        InputError: the address is not available.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except OSError as error:
        why = os.strerror(error.errno or 0)
        raise InputError(f"--port {port}: cannot listen there, at {host} ({why})") from error


def serve_http(episodes: EpisodeServer, app: Starlette, listener: socket.socket) -> None:
    """Serve an application on a socket until the process is interrupted."""
    config = uvicorn.Config(app, log_level="warning", server_header=False, limit_concurrency=_MAX_CONNECTIONS)
    server = uvicorn.Server(config)
    asyncio.run(_run_until_done(episodes, partial(server.serve, [listener])))


async def _run_until_done(worlds: EpisodeServer, run: Callable[[], Awaitable[None]]) -> None:
    """Run a server. On the signal USR1, end all episodes as soon as no tool call is running."""
    if sys.platform != "win32":
        asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, worlds.end_episodes)
    await run()
