"""``eai serve``: let agents outside this program act."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError, require_extra
from eai.cli.console import format_count, print_note
from eai.cli.options import (
    OUTPUT,
    AgentSettings,
    DataFolder,
    OfDomain,
    make_flag,
    parse_external_agent_setting,
)
from eai.cli.progress import make_command_print_how_to_resume
from eai.cli.prompts import Sample, SampleSeed, TaskIds, open_suite_for_acting_and_select_tasks
from eai.results.trials import TaskIdAndEpoch

app = typer.Typer(no_args_is_help=True)

_HTTP = "Over HTTP"
_LOOPBACK = {"127.0.0.1": "127.0.0.1", "localhost": "localhost", "::1": "[::1]"}
"""Host names of this machine in requests."""


@app.command(no_args_is_help=True)
@make_command_print_how_to_resume
def mcp(
    domain: OfDomain = "",
    out: Annotated[Path | None, make_flag(panel=OUTPUT)] = None,
    tools: bool = False,
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    settings: AgentSettings = None,
    agent: Annotated[str, make_flag(panel=OUTPUT, metavar="NAME")] = "agent",
    port: Annotated[int | None, make_flag(panel=_HTTP, metavar="N", min=1, max=65_535)] = None,
    host: Annotated[str, make_flag(panel=_HTTP, metavar="ADDRESS")] = "127.0.0.1",
    allow_host: Annotated[list[str] | None, make_flag(panel=_HTTP, metavar="NAME")] = None,
    tickets: Annotated[int, make_flag(panel=_HTTP, metavar="N", min=1)] = 1,
    trust_network: Annotated[bool, make_flag(panel=_HTTP)] = False,
    data: DataFolder = None,
) -> None:
    """Offer tasks over the Model Context Protocol, by the tools act, look and done.

    Over standard input the process serves one task. With --port each task has a ticket in OUT/tickets.json.
    The agent sends the ticket as a bearer token. A ticket is for one episode, which cannot be restarted.

    OUT/NAME_outputs.jsonl collects the episodes for eai score. An episode is added when it ends, and
    unfinished episodes are added when the server starts or stops. The same command continues unfinished
    episodes. The agent must not be able to read or write OUT.

    Example: eai serve mcp --domain virtualhome --tasks 27_2 --out runs/mine

    Example: eai serve mcp --tools

    Options:
        tools: Offer the verifier over standard input instead of tasks, by the tools check_plan, explain_plan,
            plan and predict.
        out: Folder of journals and answers.
        agent: Name of the agent in tables.
        port: Serve over HTTP at /mcp.
        host: Address to listen on.
        allow_host: Further host name that requests may use.
        tickets: Number of episodes for each task.
        trust_network: Serve one task without a ticket to everybody who reaches the port.
    """
    if tools:
        _serve_plan_verifier_tools(domain=domain, out=out, tasks=tasks, with_=settings, port=port)
        return
    if not domain or out is None:
        missing = "out" if domain else "domain"
        raise InputError(
            f"--{missing} is missing; give it, or --tools to serve the verifier instead of tasks"
        )
    setting = parse_external_agent_setting(settings or ())
    with require_extra("mcp", "eai serve mcp needs"):
        from eai.agents.episode_server import open_episode_server
        from eai.agents.server import listen, make_http_app, serve_http, serve_stdio
    suite, ids = open_suite_for_acting_and_select_tasks(domain, tasks, sample, seed, data)
    by_ticket = port is not None and not trust_network
    if not by_ticket and len(ids) != 1:
        raise InputError(
            f"--tasks: expected one task, found {len(ids):,}; to serve several tasks, give --port "
            "and --tickets"
        )
    names = allow_host or ([_LOOPBACK[host]] if host in _LOOPBACK else [])
    if port is not None and not names:
        raise InputError(f"--host {host}: also give --allow-host NAME, a host name that requests may use")
    places = [(task_id, epoch + 1) for task_id in ids for epoch in range(tickets)]
    listener = None if port is None else listen(host, port)
    with open_episode_server(out, suite, places, setting, agent) as worlds:
        if listener is None:
            serve_stdio(worlds, suite.benchmark.domain)
            return
        listening = f"http://{names[0]}:{port}/mcp"
        if by_ticket:
            listening += (
                f"; {format_count(len(places), 'ticket')} in {_write_access_tickets(out, worlds.tickets)}"
            )
        print_note(listening)
        application = make_http_app(
            worlds, suite.benchmark.domain, names, all_share_first_episode=trust_network
        )
        serve_http(worlds, application, listener)


def _serve_plan_verifier_tools(**other_options: object) -> None:
    """Serve tools that check plans and goals, over standard input (`eai serve mcp --tools`).

    Raises:
        InputError: an option is set that applies only to serving tasks.
    """
    for name, value in other_options.items():
        if value:
            raise InputError(f"--{name.strip('_')}: leave it out, because --tools serves no tasks")
    with require_extra("mcp", "eai serve mcp needs"):
        from eai.agents.server import serve_tools_over_stdio
    serve_tools_over_stdio(load_from_extension("verifier_tools", "--tools")())


def _write_access_tickets(out: Path, answer_by_ticket: Mapping[str, TaskIdAndEpoch]) -> Path:
    """Write the file of tickets (secrets with which agents open their tasks). Only its owner can read it."""
    rows = [
        {"identifier": task_id, "epoch": epoch, "ticket": ticket}
        for ticket, (task_id, epoch) in answer_by_ticket.items()
    ]
    path = out / "tickets.json"
    path.touch(0o600)
    path.chmod(0o600)  # `touch` keeps the mode of an older file
    path.write_text(json.dumps(rows, indent=1) + "\n", "utf-8")
    return path
