"""Run both tasksets in verifiers with a policy that needs no model.

    pip install ../.. .
    PYTHONPATH=../../examples/lamps python example.py

A fake server replaces the model. It answers requests like any server compatible with OpenAI's.
"""

from __future__ import annotations

import asyncio
import json
import os
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import verifiers.v1 as vf
from verifiers.v1.configs.cli.eval import EvalConfig
from verifiers.v1.env import RunSlot
from verifiers.v1.episode import Episode

COMMANDS = ("GO(lamp_1)", "PRESS(lamp_1)", "GO(lamp_2)", "PRESS(lamp_2)")
PLAN = json.dumps([{"action": c.partition("(")[0], "object": c.partition("(")[2][:-1]} for c in COMMANDS])


def policy(messages: list[dict[str, Any]]) -> str:
    """Return the reply that lights the lamps: one action if the prompt asks for one a turn, else the plan."""
    if "one action a turn" not in messages[0]["content"]:
        return PLAN
    turn = sum(message["role"] == "assistant" for message in messages)
    return COMMANDS[turn % len(COMMANDS)]


class Model(BaseHTTPRequestHandler):
    """Answers requests for chat completions with the policy."""

    protocol_version = "HTTP/1.1"

    def do_POST(self) -> None:
        """Reply to one request."""
        request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        message = {"role": "assistant", "content": policy(request["messages"])}
        reply = {
            "id": "reply",
            "object": "chat.completion",
            "created": 0,
            "model": request["model"],
            "choices": [{"index": 0, "finish_reason": "stop", "message": message}],
            "usage": {"prompt_tokens": 1, "completion_tokens": 1, "total_tokens": 2},
        }
        body = json.dumps(reply).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Write no log of requests."""


class Server(ThreadingHTTPServer):
    """Serves the model to many clients at once."""

    request_queue_size = 1024


async def evaluate(taskset: dict[str, Any], address: str, number: int) -> list[Episode]:
    """Run and return the episodes of the first tasks of a taskset."""
    os.environ.setdefault("NO_KEY", "none")
    client = {"type": "eval", "base_url": address, "api_key_var": "NO_KEY"}
    config = EvalConfig.model_validate({"env": {"taskset": taskset}, "model": "fake", "client": client})
    env = vf.load_environment(config.env)
    context = vf.ModelContext(client=config.client, model=config.model, sampling=config.sampling)
    slots = [slot for task in env.taskset.take(number) for slot in env.slots(task, 1)]

    async def run(slot: RunSlot) -> Episode:
        return await env.run_slot(slot, context, None, _ignore_episode)

    async with env.serving():
        return list(await asyncio.gather(*map(run, slots)))


async def _ignore_episode(episode: Episode) -> None:
    """Ignore a finished episode."""


def main() -> None:
    """Serve the fake model, run both tasksets, and print the rewards."""
    server = Server(("127.0.0.1", 0), Model)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}/v1"
    for name in ("eai-verifiers", "eai-verifiers-steps"):
        for episode in asyncio.run(evaluate({"id": name, "domain": "lamps:lamps"}, address, 2)):
            trace = episode.traces[0]
            metrics = {metric: value for metric, value in trace.metrics.items() if value}
            print(name, trace.task.data.name, trace.reward, metrics)
    server.shutdown()


if __name__ == "__main__":
    main()
