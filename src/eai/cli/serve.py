"""Let agents outside of this program act."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from eai.base.errors import InputError, require_extra
from eai.cli.console import counted, note
from eai.cli.options import OUTPUT, AgentSettings, DataFolder, OfDomain, flag, setting_of_others
from eai.cli.progress import resumable
from eai.cli.prompts import Sample, SampleSeed, TaskIds, playable
from eai.results.trials import AnswerKey

app = typer.Typer(no_args_is_help=True)

_HTTP = "Over HTTP"
_LOOPBACK = {"127.0.0.1": "127.0.0.1", "localhost": "localhost", "::1": "[::1]"}
"""The addresses of this machine alone, as requests write them."""


@app.command(no_args_is_help=True)
@resumable
def mcp(
    domain: OfDomain,
    out: Annotated[Path, flag(panel=OUTPUT)],
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    settings: AgentSettings = None,
    agent: Annotated[str, flag(panel=OUTPUT, metavar="NAME")] = "agent",
    port: Annotated[int | None, flag(panel=_HTTP, metavar="N", min=1, max=65_535)] = None,
    host: Annotated[str, flag(panel=_HTTP, metavar="ADDRESS")] = "127.0.0.1",
    allow_host: Annotated[list[str] | None, flag(panel=_HTTP, metavar="NAME")] = None,
    tickets: Annotated[int, flag(panel=_HTTP, metavar="N", min=1)] = 1,
    trust_network: Annotated[bool, flag(panel=_HTTP)] = False,
    data: DataFolder = None,
) -> None:
    """Offer tasks over the Model Context Protocol, by the tools act, look and done.

    Over standard input the process is the world of one task. With --port each task has a ticket, in
    OUT/tickets.json, which the agent sends as a bearer token; it is one episode, which never begins anew.

    OUT/NAME_outputs.jsonl has the episodes for eai score: each as it ends, and all that have begun once the
    server has stopped or begins again. What has not ended goes on when the same command runs again. The agent
    must not be able to read or write OUT.

    Example: eai serve mcp --domain virtualhome --tasks 27_2 --out runs/mine

    Options:
        out: Where journals and answers go.
        agent: Who acts, as tables name it.
        port: Serve over HTTP at /mcp.
        host: Where to listen.
        allow_host: What requests may call this host.
        tickets: Episodes of each task.
        trust_network: No tickets: one task, for whoever reaches the port.
    """
    setting = setting_of_others(settings or ())
    with require_extra("mcp", "eai serve mcp needs"):
        from eai.agents.episode_server import open_episodes
        from eai.agents.server import listen, make_http_app, serve_http, serve_stdio
    suite, ids = playable(domain, tasks, sample, seed, data)
    by_ticket = port is not None and not trust_network
    if not by_ticket and len(ids) != 1:
        raise InputError(f"--tasks: expected one task, found {len(ids):,}; several need --port and tickets")
    names = allow_host or ([_LOOPBACK[host]] if host in _LOOPBACK else [])
    if port is not None and not names:
        raise InputError(f"--host {host}: expected --allow-host NAME, what requests may call this host")
    places = [(task_id, epoch + 1) for task_id in ids for epoch in range(tickets)]
    listener = None if port is None else listen(host, port)
    with open_episodes(out, suite, places, setting, agent) as worlds:
        if listener is None:
            serve_stdio(worlds, suite.benchmark.domain)
            return
        listening = f"http://{names[0]}:{port}/mcp"
        if by_ticket:
            listening += f"; {counted(len(places), 'ticket')} in {_write_tickets(out, worlds.tickets)}"
        note(listening)
        application = make_http_app(worlds, suite.benchmark.domain, names, open_to_all=trust_network)
        serve_http(worlds, application, listener)


def _write_tickets(out: Path, tickets: Mapping[str, AnswerKey]) -> Path:
    """Write the tickets for who hands them out, whom alone they are for."""
    rows = [
        {"identifier": task_id, "epoch": epoch, "ticket": ticket}
        for ticket, (task_id, epoch) in tickets.items()
    ]
    path = out / "tickets.json"
    path.touch(0o600)
    path.write_text(json.dumps(rows, indent=1) + "\n", "utf-8")
    return path
