"""The verifier's tools for servers: each call is a query, answered by a process with limits.

A process answers one query at a time and keeps opened benchmarks for later queries. Results depend only on
the arguments of the query.
"""

from __future__ import annotations

import asyncio
import json
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from eai.base.errors import InputError
from eai.extensions.verifier.queries import QUERIES, check_arguments, describe_tool
from eai.extensions.verifier.worker import MAX_RESULT
from eai.pddl.limited import make_limited_command

MAX_REQUEST = 65_536
"""Maximum size of the name and the arguments of a call, in bytes of JSON."""

_CPU_SECONDS = 3_600
"""Maximum CPU seconds of a process for all calls that it answers; then the operating system ends it."""

_COMMAND = (sys.executable, str(Path(__file__).with_name("worker.py")))


class _PlanningToolsForAgents:
    """Tools that check, explain and find plans, and predict effects of actions.

    Attributes:
        instructions: text for the model that may call the tools.
    """

    instructions = (
        "Ask for verdicts on plans of embodied tasks, for plans, and for effects of actions. "
        "Calls are independent: every call names its benchmark and its task."
    )

    def __init__(self, seconds: float, memory_mib: int, processes: int) -> None:
        self._seconds = seconds
        self._memory_mib = memory_mib
        self._permits = asyncio.Semaphore(processes)
        self._idle: list[Process] = []

    def list_tool_names_texts_and_schemas(self) -> Sequence[tuple[str, str, Mapping[str, Any]]]:
        """Return name, description, and JSON schema of the arguments of each tool."""
        return [(name, *describe_tool(name)) for name in QUERIES]

    async def call_tool(self, name: str, arguments: Mapping[str, object]) -> str:
        """Return the result of a call as JSON.

        A process answers many calls, so earlier calls may have used its memory. If it ends without an answer,
        a new process answers the call.

        Raises:
            InputError: the call is invalid, or needs too much time or memory.
        """
        check_arguments(name, arguments)
        request = json.dumps({"name": name, "arguments": arguments}).encode() + b"\n"
        if len(request) > MAX_REQUEST:
            raise InputError(
                f"the call has {len(request):,} bytes: shorten its arguments to {MAX_REQUEST:,} bytes in all"
            )
        async with self._permits:
            reply = b""
            if self._idle:
                reply = await self._ask(self._idle.pop(), request)
            if not reply:
                reply = await self._ask(await self._start_process(), request)
        if not reply:
            raise InputError(
                f"{name} needs more than {self._memory_mib:,} MiB of memory, or crashed; "
                "give a smaller task or a shorter plan"
            )
        values = json.loads(reply)
        if "error" in values:
            raise InputError(values["error"])
        return json.dumps(values["result"], ensure_ascii=False)

    async def close(self) -> None:
        """End the processes that wait for calls."""
        while self._idle:
            await _kill(self._idle.pop())

    async def _ask(self, process: Process, request: bytes) -> bytes:
        """Send a request to a process. Return the reply; empty if the process ended without a reply."""
        reply = b""
        try:
            reply = await asyncio.wait_for(_exchange(process, request), self._seconds)
        except asyncio.TimeoutError:
            raise InputError(
                f"the call needs more than {self._seconds:g} seconds; give a smaller task or a shorter plan"
            ) from None
        finally:
            if reply:
                self._idle.append(process)
            else:  # the process ended, the time is over, or the client cancelled the call
                await _kill(process)
        return reply

    async def _start_process(self) -> Process:
        command = make_limited_command(_COMMAND, _CPU_SECONDS, self._memory_mib << 20)
        return await asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE, limit=2 * MAX_RESULT)


def open_verifier_tools(
    seconds: float = 30, memory_mib: int = 2048, processes: int = 2
) -> _PlanningToolsForAgents:
    """Return tools by which agents check, explain and find plans, and predict effects of actions.

    The processes that answer calls start on first use.

    Args:
        seconds: maximum wall-clock seconds of a call, without the time that it waits for other calls.
        memory_mib: maximum memory of a process, in MiB.
        processes: maximum number of processes, which is the number of calls that are answered at a time.
    """
    return _PlanningToolsForAgents(seconds, memory_mib, processes)


async def _exchange(process: Process, request: bytes) -> bytes:
    if process.stdin is None or process.stdout is None:
        raise TypeError("the process has no pipes: start it with stdin=PIPE and stdout=PIPE")
    with suppress(BrokenPipeError, ConnectionResetError):
        process.stdin.write(request)
        await process.stdin.drain()
    reply = await process.stdout.readline()
    return reply if reply.endswith(b"\n") else b""  # a process that dies can leave half a line


async def _kill(process: Process) -> None:
    with suppress(ProcessLookupError):
        process.kill()
    if process.stdin is not None:
        process.stdin.close()
    await process.wait()
