"""The verifier's tools answer clients of the protocol, within limits of time, memory and size."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")

from mcp import Client, StdioServerParameters

from command_line import Command
from eai.agents.server import make_tool_server
from eai.extensions.verifier.queries import QUERIES, answer_query
from eai.extensions.verifier.tools import MAX_REQUEST, open_verifier_tools

WORLDS = Path(__file__).parents[2] / "worlds"
BLOCKS = {"benchmark": f"pddl:{WORLDS}/blocks.pddl,{WORLDS}/blocks-1.pddl", "task": "swap"}
GOOD = "(unstack b a)\n(stack b c)\n(pick-up a)\n(stack a b)"


@asynccontextmanager
async def clients(count: int = 1, **limits: float) -> AsyncIterator[list[Client]]:
    """Return clients of one server."""
    tools = open_verifier_tools(**limits)  # type: ignore[arg-type]
    server = make_tool_server(tools)
    try:
        async with Client(server) as first:
            if count == 1:
                yield [first]
                return
            async with Client(server) as second:
                yield [first, second]
    finally:
        await tools.close()


async def call(client: Client, name: str, **arguments: object) -> Any:
    """Return the result of a call, or the message of its error."""
    result = await client.call_tool(name, arguments)
    (part,) = result.content
    text = part.text  # type: ignore[union-attr]
    return text if result.is_error else json.loads(text)


def run(test: Callable[[list[Client]], Awaitable[None]], count: int = 1, **limits: float) -> None:
    async def start() -> None:
        async with clients(count, **limits) as opened:
            await test(opened)

    asyncio.run(start())


def test_the_tools_are_listed_with_their_arguments() -> None:
    async def check(opened: list[Client]) -> None:
        tools = {tool.name: tool.input_schema for tool in (await opened[0].list_tools()).tools}
        assert list(tools) == ["check_plan", "explain_plan", "plan", "predict"]
        assert tools["predict"]["required"] == ["benchmark", "task", "action"]

    run(check)


def test_a_client_gets_the_results_of_the_queries() -> None:
    async def check(opened: list[Client]) -> None:
        for name, more in (
            ("check_plan", {"plan": GOOD}),
            ("explain_plan", {"plan": "(pick-up a)"}),
            ("plan", {}),
            ("predict", {"action": "(unstack b a)"}),
            ("predict", {"action": "(stack b c)", "after": "(unstack b a)"}),
        ):
            arguments = BLOCKS | more
            expected = json.loads(json.dumps(answer_query(name, arguments)))
            assert await call(opened[0], name, **arguments) == expected

    run(check)


def test_two_parallel_clients_get_their_own_results() -> None:
    async def ask(client: Client, plan: str) -> list[bool]:
        return [(await call(client, "check_plan", **BLOCKS, plan=plan))["success"] for _ in range(30)]

    async def check(opened: list[Client]) -> None:
        first, second = opened
        good, bad = await asyncio.gather(ask(first, GOOD), ask(second, "(pick-up a)"))
        assert (set(good), set(bad)) == ({True}, {False})

    run(check, count=2)


def test_errors_are_messages_and_later_calls_are_answered() -> None:
    async def check(opened: list[Client]) -> None:
        (client,) = opened
        told = await call(client, "check_plan", **BLOCKS | {"task": "moon"}, plan=GOOD)
        assert told == "blocks action_sequencing has no task 'moon'"
        assert await call(client, "fly") == (
            "there is no tool 'fly': expected one of check_plan, explain_plan, plan, predict"
        )
        large = await call(client, "check_plan", **BLOCKS, plan="x" * MAX_REQUEST)
        assert large.endswith("bytes: shorten its arguments to 65,536 bytes in all")
        assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]

    run(check)


def write_pair(folder: Path, domain: str, problem: str) -> dict[str, str]:
    """Write a PDDL pair, and return the arguments that name its problem."""
    (folder / "d.pddl").write_text(domain)
    (folder / "p.pddl").write_text(problem)
    return {"benchmark": f"pddl:{folder}/d.pddl,{folder}/p.pddl", "task": "p"}


def write_long_quantifier(folder: Path) -> dict[str, str]:
    """Write an action whose condition is about 400 ** 8 combinations of objects."""
    objects = " ".join(f"o{i}" for i in range(400))
    variables = [f"?x{i}" for i in range(8)]
    condition = f"(forall ({' '.join(variables)}) (or {' '.join(f'(q {name})' for name in variables)} (g)))"
    facts = " ".join(f"(q o{i})" for i in range(399))
    return write_pair(
        folder,
        f"(define (domain d) (:predicates (q ?x) (g)) (:action a :parameters () :precondition {condition} "
        ":effect (g)))",
        f"(define (problem p) (:domain d) (:objects {objects}) (:init {facts}) (:goal (g)))",
    )


DEEP = {
    "parentheses": "(" * 200_000,
    "conditions": "(define (domain d) (:predicates (g)) (:action a :parameters () :precondition "
    f"{'(and ' * 50_000}(g){')' * 50_000} :effect (g)))",
}


def test_a_call_that_takes_too_long_ends_with_a_message(tmp_path: Path) -> None:
    hostile = write_long_quantifier(tmp_path)

    async def check(opened: list[Client]) -> None:
        (client,) = opened
        late = "the call needs more than 4 seconds; give a smaller task or a shorter plan"
        assert await call(client, "predict", **hostile, action="(a)") == late
        answers = [await call(client, "check_plan", **BLOCKS, plan=GOOD)]
        while answers[-1] == late and len(answers) < 20:  # a busy machine may take longer to start a process
            answers.append(await call(client, "check_plan", **BLOCKS, plan=GOOD))
        assert answers[-1]["success"]

    run(check, seconds=4)


@pytest.mark.parametrize("text", [*DEEP])
def test_deep_pddl_gets_a_message(tmp_path: Path, text: str) -> None:
    hostile = write_pair(tmp_path, DEEP[text], "(define (problem p) (:domain d) (:goal (g)))")

    async def check(opened: list[Client]) -> None:
        (client,) = opened
        assert isinstance(await call(client, "plan", **hostile), str)
        assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]

    run(check)


def test_a_file_that_exceeds_the_memory_gets_a_message(tmp_path: Path) -> None:
    hostile = write_pair(tmp_path, "", "")
    os.truncate(tmp_path / "d.pddl", 4 << 30)  # a sparse file, which takes no space on the disk

    async def check(opened: list[Client]) -> None:
        (client,) = opened
        assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]
        told = await call(client, "plan", **hostile)
        assert told.startswith("plan needs more than 512 MiB of memory, or crashed; give a smaller task")
        assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]

    run(check, memory_mib=512)


def test_a_device_is_refused_and_does_not_take_the_next_request() -> None:
    async def check(opened: list[Client]) -> None:
        (client,) = opened
        told = await call(client, "plan", benchmark="pddl:/dev/zero,/dev/zero", task="p")
        assert told.startswith("/dev/zero: is a device")
        assert isinstance(await call(client, "plan", benchmark="pddl:/dev/stdin,/dev/stdin", task="p"), str)
        assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]

    run(check, seconds=20)


def test_the_command_serves_over_standard_input() -> None:
    async def check() -> None:
        command = StdioServerParameters(command=sys.executable, args=["-m", "eai", "serve", "mcp", "--tools"])
        async with Client(command) as client:
            assert len((await client.list_tools()).tools) == len(QUERIES)
            assert (await call(client, "check_plan", **BLOCKS, plan=GOOD))["success"]

    asyncio.run(check())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--tools --domain behavior", "--domain: leave it out, because --tools serves no tasks"),
        ("--tools --with view=task", "--with: leave it out, because --tools serves no tasks"),
        ("--domain behavior", "--out is missing; give it, or --tools to serve the verifier instead of tasks"),
        ("--out x", "--domain is missing; give it, or --tools to serve the verifier instead of tasks"),
    ],
)
def test_options_that_do_not_fit_are_refused(eai: Command, words: str, message: str) -> None:
    done = eai("serve", "mcp", *words.split())
    assert (done.status, done.out, done.err.strip()) == (2, "", f"eai: {message}")


def test_half_a_reply_of_a_process_that_died_is_no_reply(monkeypatch: pytest.MonkeyPatch) -> None:
    dying = (sys.executable, "-c", """input(); print('{"result"', end="", flush=True)""")
    monkeypatch.setattr("eai.extensions.verifier.tools._COMMAND", dying)

    async def test(opened: list[Client]) -> None:
        for _ in range(2):
            assert "or crashed" in await call(opened[0], "plan", **BLOCKS)

    run(test)
