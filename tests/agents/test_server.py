"""Agents act over the Model Context Protocol: each ticket is one episode, and other requests are refused."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

pytest.importorskip("mcp", reason="no mcp: pip install 'eai-bench[mcp]'")

import httpx2
from mcp import Client, MCPError, StdioServerParameters
from mcp.client.streamable_http import streamable_http_client

from agents.switches import SWITCHES
from eai.agents.episode_server import EpisodeServer, find_journal_path, open_episode_server
from eai.agents.play import OVER, EpisodeFactory, RecordedGame
from eai.agents.server import MAX_BODY, MAX_COMMAND, make_http_app, make_mcp_server
from eai.agents.setting import ACTING, AgentSetting
from eai.agents.verdict import EpisodeVerdict
from eai.base.errors import InputError
from eai.benchmarks.suite import open_suite
from eai.results.responses import read_responses
from eai.tasks.prompts.prompt import Image
from processes import wait_until

SUITE = open_suite(SWITCHES, ACTING)
TASK = SUITE.task_ids[0]
ONE = [(TASK, 1)]
TWO = [(TASK, 1), (TASK, 2)]
HOST = "world"
URL = f"http://{HOST}:1/mcp"
WINNING = [*(EpisodeFactory(SWITCHES).make_setup(SUITE.tasks[TASK]).reference.commands or ())]
DOMAIN = "agents.switches:SWITCHES"
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


class Call(NamedTuple):
    text: str
    failed: bool


async def call(client: Client, name: str, **arguments: object) -> Call:
    result = await client.call_tool(name, arguments)
    (part,) = result.content
    return Call(part.text, bool(result.is_error))  # type: ignore[union-attr]


async def act(client: Client, command: str) -> str:
    name, _, objects = command.removesuffix(")").partition("(")
    told = await call(client, "act", action=name, objects=objects.split(", ") if objects else [])
    assert not told.failed
    return told.text


async def win(client: Client) -> None:
    for command in WINNING:
        await act(client, command)
    await call(client, "done")


def verdicts(folder: Path, name: str = "agent") -> dict[str, EpisodeVerdict]:
    answers = read_responses(folder / f"{name}_outputs.jsonl", SUITE.task_ids).responses
    found = {answer.task_id: SUITE.score(answer.task_id, answer.text) for answer in answers}
    return {task_id: each for task_id, each in found.items() if isinstance(each, EpisodeVerdict)}


@asynccontextmanager
async def served(worlds: EpisodeServer, *, open_to_all: bool = False) -> AsyncIterator[httpx2.ASGITransport]:
    """Return the application without a port; it handles requests like one with a port."""
    app = make_http_app(worlds, SWITCHES.domain, [HOST], all_share_first_episode=open_to_all)
    async with app.router.lifespan_context(app):
        yield httpx2.ASGITransport(app=app)


@asynccontextmanager
async def client_with(ticket: str, transport: Any = None, url: str = URL) -> AsyncIterator[Client]:
    headers = {"Authorization": f"Bearer {ticket}"}
    async with (
        httpx2.AsyncClient(headers=headers, transport=transport) as http,
        Client(streamable_http_client(url, http_client=http)) as client,
    ):
        yield client


def test_the_tools_are_made_from_the_declaration(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            tools = {tool.name: tool for tool in (await client.list_tools()).tools}
            assert list(tools) == ["act", "look", "done"]
            told = tools["act"].input_schema["properties"]["action"]["description"]
            assert all(operator.name in told for operator in SWITCHES.domain.operators)
            assert (await call(client, "fly")).failed
            assert (
                await call(client, "act", action="x", objects="y")
            ).text == "arguments: expected `action`, the name of an action, and `objects`, a list of names"
            assert (await call(client, "act", action="x" * MAX_COMMAND, objects=[])).failed
            assert (await call(client, "act", action=WINNING[0])).failed

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))
        assert not find_journal_path(tmp_path, ONE[0]).exists()  # none of these calls reached the episode


def test_an_agent_reads_its_task_and_wins(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            first = await call(client, "look")
            assert first.text == EpisodeFactory(SWITCHES).make_prompt(SUITE.tasks[TASK]).user
            assert first == await call(client, "look")
            told = await act(client, WINNING[0])
            assert told.startswith(f"{WINNING[0]}: done.")
            assert "Now:" in (await call(client, "look")).text
            for command in WINNING[1:]:
                await act(client, command)
            assert "goals" not in (await call(client, "done")).text
            assert {(await call(client, name)).text for name in ("look", "done")} == {OVER}
            assert await act(client, WINNING[0]) == OVER

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))
    verdict = verdicts(tmp_path)[TASK]
    assert (verdict.success, verdict.harness) == (True, "mcp")
    assert [turn.said for turn in verdict.turns] == [WINNING[0], "LOOK", *WINNING[1:], "DONE"]


def test_pictures_accompany_observations(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            told, shown = (await client.call_tool("look", {})).content
            assert "Now:\nWhat the pictures show." in told.text  # type: ignore[union-attr]
            assert (shown.type, shown.mime_type) == ("image", "image/png")
            assert base64.b64decode(shown.data) == b"picture"

    monkeypatch.setattr(
        RecordedGame, "draw_pictures_of_current_world", lambda play: (Image("image/png", b"picture"),)
    )
    setting = AgentSetting(feedback="pictures", observe="full")
    with open_episode_server(tmp_path, SUITE, ONE, setting) as worlds:
        asyncio.run(run(worlds))


def test_a_whole_plan_in_one_call_is_one_error(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            for plan in ("\n".join([*WINNING, "DONE"]), f"[{', '.join(WINNING)}]"):
                await call(client, "act", action=plan, objects=[])
            await call(client, "done")

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))
    verdict = verdicts(tmp_path)[TASK]
    assert (verdict.success, [turn.fault is None for turn in verdict.action_turns]) == (False, [False, False])


def test_each_ticket_is_one_episode_forever(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer, *, again: bool) -> None:
        first, second = worlds.tickets
        async with (
            served(worlds) as transport,
            client_with(first, transport) as one,
            client_with(second, transport) as other,
        ):
            if again:
                assert (await call(one, "look")).text == OVER
                return
            assert "Goals:" in (await call(other, "look")).text
            await win(one)
            assert "Goals:" in (await call(other, "look")).text

    with open_episode_server(tmp_path, SUITE, TWO) as worlds:
        before = dict(worlds.tickets)
        asyncio.run(run(worlds, again=False))
    with open_episode_server(tmp_path, SUITE, TWO) as worlds:
        assert worlds.tickets == before
        asyncio.run(run(worlds, again=True))
    assert verdicts(tmp_path)[TASK].success
    assert not verdicts(tmp_path, "agent-2")[TASK].turns  # a look begins the episode, which is lost


def test_an_unfinished_episode_is_an_answer(tmp_path: Path) -> None:
    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        worlds.play_command(ONE[0], WINNING[0])
    assert (verdicts(tmp_path)[TASK].ended, len(verdicts(tmp_path)[TASK].turns)) == ("stopped", 1)
    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        for command in (*WINNING[1:], "DONE"):
            worlds.play_command(ONE[0], command)
        assert verdicts(tmp_path)[TASK].success  # written at once, and only once


def test_ended_episodes_are_over(tmp_path: Path) -> None:
    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        worlds.play_command(ONE[0], WINNING[0])
        worlds.end_episodes()
        assert worlds.play_command(ONE[0], WINNING[1]) == OVER
        assert len(verdicts(tmp_path)[TASK].turns) == 1


def test_a_folder_belongs_to_one_suite_setting_and_process(tmp_path: Path) -> None:
    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        worlds.play_command(ONE[0], "LOOK")
        with pytest.raises(InputError, match="another process"), open_episode_server(tmp_path, SUITE, ONE):
            pass
    with (
        pytest.raises(InputError, match="other agent options"),
        open_episode_server(tmp_path, SUITE, ONE, AgentSetting(budget=4)),
    ):
        pass
    find_journal_path(tmp_path, ("moon", 1)).touch()
    with (
        pytest.raises(InputError, match="this folder belongs to other tasks"),
        open_episode_server(tmp_path, SUITE, ONE),
    ):
        pass


BODY = json.dumps(
    {
        "jsonrpc": "2.0",
        "id": 1,
        "method": "tools/call",
        "params": {
            "name": "done",
            "arguments": {},
            "_meta": {
                "io.modelcontextprotocol/protocolVersion": "2026-07-28",
                "io.modelcontextprotocol/clientInfo": {"name": "x", "version": "1"},
                "io.modelcontextprotocol/clientCapabilities": {},
            },
        },
    }
).encode()
HEADERS = {
    "Content-Type": "application/json",
    "Accept": "application/json, text/event-stream",
    "MCP-Protocol-Version": "2026-07-28",
    "Mcp-Method": "tools/call",
    "Mcp-Name": "done",
}
SAID_DONE = b'"name": "done"'


@pytest.mark.parametrize(
    ("headers", "body", "status"),
    [
        ({"Host": "evil.example"}, BODY, 421),
        ({"Host": f"{HOST}.evil.example:1"}, BODY, 421),
        ({"Origin": "http://evil.example"}, BODY, 403),
        ({"Origin": f"http://{HOST}:1"}, BODY, 403),
        ({"Authorization": ""}, BODY, 401),
        ({"Authorization": "Bearer"}, BODY, 401),
        ({"Authorization": "Bearer " + "0" * 64}, BODY, 401),
        ({"Authorization": "Basic TICKET"}, BODY, 401),
        ({}, b"A" * 5_000_000, 413),
        ({}, BODY.replace(SAID_DONE, b'"name": "' + b"x" * MAX_BODY + b'"'), 413),
        ({}, b"[" * 60_000, 400),
        ({}, b'{"a":' * 10_000, 400),
        ({}, b"\xff\xfe\xfd", 400),
        ({}, BODY.replace(b"done", b"\xff"), 400),
        ({}, b"", 400),
        ({"Content-Type": "text/plain"}, BODY, 400),
    ],
)
def test_other_requests_than_an_agents_are_refused(
    tmp_path: Path, headers: dict[str, str], body: bytes, status: int
) -> None:
    async def run(worlds: EpisodeServer) -> None:
        (ticket,) = worlds.tickets
        given = {name: value.replace("TICKET", ticket) for name, value in headers.items()}
        async with served(worlds) as transport, httpx2.AsyncClient(transport=transport) as http:
            good = {**HEADERS, "Authorization": f"Bearer {ticket}"}
            refused = await http.post(URL, headers={**good, **given}, content=body)
            assert refused.status_code == status, refused.text
            assert not find_journal_path(tmp_path, ONE[0]).exists()
            allowed = await http.post(URL, headers=good, content=BODY)
            assert allowed.status_code == 200
            assert "DONE." in allowed.text

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))


def test_there_is_no_other_route(tmp_path: Path) -> None:
    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        app = make_http_app(worlds, SWITCHES.domain, [HOST])
        assert [route.path for route in app.routes] == ["/mcp"]  # type: ignore[attr-defined]


@pytest.mark.parametrize("text", ["\0" * 100, "\u202e\U0001f600" * 50, "(" * 1000, "DONE\nDONE", "9" * 1900])
def test_a_strange_command_is_an_error_of_the_action(tmp_path: Path, text: str) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            assert (await act_raw(client, text)).startswith("Failed (")
            assert (await act_raw(client, WINNING[0].partition("(")[0], text)).startswith("Failed (")
            await win(client)

    async def act_raw(client: Client, action: str, *objects: str) -> str:
        return (await call(client, "act", action=action, objects=[*objects])).text

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))
    assert verdicts(tmp_path)[TASK].success


def test_many_calls_at_once_are_turns_one_after_the_other(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with served(worlds) as transport, client_with(next(iter(worlds.tickets)), transport) as client:
            await asyncio.gather(*[act(client, WINNING[0]) for _ in range(16)])

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        asyncio.run(run(worlds))
        worlds.end_episodes()
    verdict = verdicts(tmp_path)[TASK]
    assert verdict.excluded is None
    assert len(verdict.turns) == min(16, (verdict.budget or 0) + 1)


def test_errors_do_not_reveal_files_to_the_agent(tmp_path: Path) -> None:
    async def run(worlds: EpisodeServer) -> None:
        async with Client(make_mcp_server(worlds, SWITCHES.domain)) as client:
            with pytest.raises(MCPError, match=r"^the world is out of order$"):
                await call(client, "look")

    with open_episode_server(tmp_path, SUITE, ONE) as worlds:
        path = find_journal_path(tmp_path, ONE[0])
        path.parent.mkdir(parents=True)
        path.write_text("0 {}\n")
        asyncio.run(run(worlds))
        path.unlink()


def command(out: Path, *words: object) -> list[str]:
    program = [sys.executable, "-W", "ignore", "-c", "from eai.cli import main; main()"]
    return [*program, "serve", "mcp", "--domain", DOMAIN, "--out", str(out), *map(str, words)]


def test_a_process_over_standard_input_serves_one_episode(tmp_path: Path) -> None:
    async def run() -> list[str]:
        program, *arguments = command(tmp_path, "--tasks", TASK)
        server = StdioServerParameters(command=program, args=arguments, env=ENVIRONMENT)
        async with Client(server) as client:
            first = await call(client, "look")
            await win(client)
            return [first.text, (await call(client, "look")).text]

    first, last = asyncio.run(run())
    assert (first.startswith("You act in"), last) == (True, OVER)
    assert verdicts(tmp_path)[TASK].success
    assert asyncio.run(run())[0] == OVER


def test_sigterm_ends_a_server_with_open_input(tmp_path: Path) -> None:
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "env": ENVIRONMENT}
    with subprocess.Popen(command(tmp_path, "--tasks", TASK), **pipes) as started:
        started.stdin.write(b'{"jsonrpc": "2.0", "id": 1, "method": "ping"}\n')
        started.stdin.flush()
        assert started.stdout.readline()
        started.terminate()
        assert started.wait(60) == 143


class Process(NamedTuple):
    url: str
    process: subprocess.Popen[str]
    tickets: Sequence[str]


@contextmanager
def process(out: Path, *words: object) -> Iterator[Process]:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    words = ("--tasks", TASK, "--port", port, *words)
    with subprocess.Popen(
        command(out, *words), stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    ) as started:
        try:
            assert started.stderr is not None
            url = started.stderr.readline().split(";")[0].strip()
            assert url == f"http://127.0.0.1:{port}/mcp"
            assert wait_until(lambda: started.poll() is not None or answers(port))
            rows = json.loads((out / "tickets.json").read_text()) if (out / "tickets.json").exists() else []
            yield Process(url, started, [row["ticket"] for row in rows])
        finally:
            started.kill()


def answers(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), timeout=5).close()
    except OSError:
        return False
    return True


def test_a_killed_server_can_resume(tmp_path: Path) -> None:
    async def acts(server: Process, commands: Sequence[str]) -> None:
        async with client_with(server.tickets[0], url=server.url) as client:
            for each in commands:
                await act(client, each)

    with process(tmp_path) as server:
        asyncio.run(acts(server, WINNING[:-1]))
        server.process.send_signal(signal.SIGKILL)
    with (tmp_path / "episodes" / "1" / f"{TASK}.journal").open("ab") as journal:
        journal.write(b"0123456789")  # a torn line
    with process(tmp_path) as server:
        asyncio.run(acts(server, [WINNING[-1], "DONE"]))
        server.process.terminate()
        assert server.process.wait(60) == 143
    assert verdicts(tmp_path)[TASK].success
    assert (tmp_path / "tickets.json").stat().st_mode & 0o777 == 0o600


def test_a_signal_ends_the_episodes_and_broken_requests_do_not(tmp_path: Path) -> None:
    broken = [
        b"POST /mcp HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999\r\n\r\nabc",
        b"\0\0\0\0\r\n\r\n",
        b"GET " + b"/" * 100_000,
    ]
    with process(tmp_path) as server:
        port = int(server.url.split(":")[2].split("/")[0])
        for each in broken:
            with socket.create_connection(("127.0.0.1", port)) as connection:
                connection.sendall(each)
        with pytest.raises(urllib.error.HTTPError, match="401"):
            urllib.request.urlopen(server.url, data=BODY)  # noqa: S310

        async def run() -> str:
            async with client_with(server.tickets[0], url=server.url) as client:
                await act(client, WINNING[0])
                server.process.send_signal(signal.SIGUSR1)
                journal = tmp_path / "episodes" / "1" / f"{TASK}.journal"
                assert wait_until(lambda: b'{"end": "stopped"}' in journal.read_bytes())
                return await act(client, WINNING[1])

        assert asyncio.run(run()) == OVER
    verdict = verdicts(tmp_path)[TASK]
    assert (verdict.success, verdict.ended, len(verdict.turns)) == (False, "stopped", 1)


def test_a_trusted_network_has_one_episode_without_a_ticket(tmp_path: Path) -> None:
    async def run(server: Process) -> None:
        async with Client(server.url) as client:
            await win(client)
        async with Client(server.url) as client:
            assert (await call(client, "look")).text == OVER

    with process(tmp_path, "--trust-network") as server:
        asyncio.run(run(server))
    assert verdicts(tmp_path)[TASK].success
