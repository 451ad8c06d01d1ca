"""Let the OpenAI Agents SDK play over `eai serve mcp` with a scripted model.

    python -m venv agents && agents/bin/pip install openai-agents
    python -m bench mcp_agent --python agents/bin/python [--domain virtualhome] [--tasks 10]

The model is a server on this machine. It looks, says the commands of the reference plan one after the other,
and ends the episode. The program prints the episodes, the number won, and the seconds.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from bench.record import add_write_option, write_rows
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.benchmarks.suite import Suite, open_suite
from eai.results.responses import read_responses

AGENT = Path(__file__).parents[1] / "examples/mcp/openai_agents.py"


def choose_next_call(
    messages: Sequence[Mapping[str, Any]], gold: Mapping[str, Sequence[str]]
) -> tuple[str, object]:
    """Return the tool that the model calls after these messages, and its arguments."""
    told = [message["content"] for message in messages if message["role"] == "tool"]
    asked = [message["content"] for message in messages if message["role"] == "user"]
    taken = len(told)
    if asked[0] in gold:  # an agent in Inspect reads the task in its question
        commands = gold[asked[0]]
    elif not told:
        return "look", {}
    else:
        question = told[0] if isinstance(told[0], str) else told[0][0]["text"]
        question = json.loads(question)["text"] if question.startswith('{"') else question
        commands, taken = gold[question], len(told) - 1
    if taken == len(commands):
        return "done", {}
    name, _, objects = commands[taken].removesuffix(")").partition("(")
    return "act", {"action": name, "objects": objects.split(", ") if objects else []}


@contextmanager
def serve_model(gold: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Serve a scripted model as OpenAI chat completions, and yield its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            messages = json.loads(self.rfile.read(int(self.headers["Content-Length"])))["messages"]
            over = any(each.get("tool_calls", [{"id": ""}])[0]["id"].startswith("done") for each in messages)
            message: dict[str, Any] = {"role": "assistant", "content": "It is done." if over else None}
            if not over:
                name, arguments = choose_next_call(messages, gold)
                function = {"name": name, "arguments": json.dumps(arguments)}
                message["tool_calls"] = [
                    {"id": f"{name}-{len(messages)}", "type": "function", "function": function}
                ]
            choice = {"index": 0, "message": message, "finish_reason": "stop" if over else "tool_calls"}
            usage = {"prompt_tokens": 1, "completion_tokens": 1, "total_tokens": 2}
            made = {"id": "x", "object": "chat.completion", "created": 0, "model": "scripted", "usage": usage}
            body = json.dumps({**made, "choices": [choice]}).encode()
            self.send_response(200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            """Write no log of requests."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/v1"
        server.shutdown()


def list_winning_commands(suite: Suite, tickets: Path) -> dict[str, Sequence[str]]:
    """Return the commands that win each ticket's task, by the text of its question."""
    arena = EpisodeFactory(suite.benchmark)
    tasks = [suite.tasks[row["identifier"]] for row in json.loads(tickets.read_text("utf-8"))]
    return {arena.make_prompt(task).user: arena.make_setup(task).reference.commands or () for task in tasks}


def accepts_connections(port: int) -> bool:
    """Return whether a server listens at a port of this machine."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def main() -> None:
    """Play the tasks, score the episodes, and print the number won."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--python", type=Path, required=True, help="of the environment with openai-agents")
    parser.add_argument("--domain", default="virtualhome")
    parser.add_argument("--tasks", type=int, default=10)
    add_write_option(parser)
    arguments = parser.parse_args()
    suite = open_suite(arguments.domain, ACTING)
    program = [sys.executable, "-c", "from eai.cli import main; main()", "serve", "mcp"]
    options = ["--domain", arguments.domain, "--sample", str(arguments.tasks), "--port", "8000"]
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen([*program, *options, "--out", f"{folder}/served"]) as server,
    ):
        tickets = Path(folder, "served", "tickets.json")
        while server.poll() is None and not (tickets.exists() and accepts_connections(8000)):
            time.sleep(0.1)
        with serve_model(list_winning_commands(suite, tickets)) as url:
            start = time.monotonic()
            keys = {"OPENAI_BASE_URL": url, "OPENAI_API_KEY": "none", "OPENAI_AGENTS_DISABLE_TRACING": "1"}
            command = [str(arguments.python), str(AGENT)]
            subprocess.run(command, cwd=folder, env={**os.environ, **keys}, check=True)
            spent = time.monotonic() - start
        server.terminate()
        server.wait()
        answers = read_responses(Path(folder, "served", "agent_outputs.jsonl"), suite.task_ids).responses
        verdicts: list[Any] = [suite.score(answer.task_id, answer.text) for answer in answers]
        won = sum(bool(verdict.success) for verdict in verdicts)
        turns = sum(len(verdict.turns) for verdict in verdicts)
        print(f"{won} of {len(verdicts)} episodes won, {turns} turns, {spent:.1f} s")
    if arguments.write:
        write_rows("mcp_agent", [[arguments.domain, f"{won} of {len(verdicts)}", turns, round(spent)]])
