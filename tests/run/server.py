"""A small OpenAI-compatible server with scripted answers and faults."""

from __future__ import annotations

import contextlib
import json
import socket
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

COUNTED = {"prompt_tokens": 11, "completion_tokens": 7, "total_tokens": 18}
"""Usage of replies."""


@dataclass(frozen=True)
class Reply:
    """The reply to one request.

    Attributes:
        text: content of the message.
        status: HTTP status; there is no message unless it is 200.
        retry_after: value of the header of that name, in seconds.
        delay: seconds before the reply begins.
        cut: close the connection in the middle of the reply.
        reset: reset the connection before the reply.
        drip: seconds between the ten pieces of the reply.
        body: body that replaces the completion.
        message: fields of the message that replace or join its text.
        finish: finish reason of the message.
        reasoning: value of the field ``reasoning_content``.
        usage: usage of the reply.
        unless: parameters that make the server reply with status 400.
        empty_if: parameters that make the message empty.
    """

    text: str = ""
    status: int = 200
    retry_after: str | None = None
    delay: float = 0.0
    cut: bool = False
    reset: bool = False
    drip: float = 0.0
    body: str | None = None
    message: Mapping[str, Any] = field(default_factory=dict)
    finish: str = "stop"
    reasoning: str | None = None
    usage: object = field(default_factory=lambda: COUNTED)
    unless: tuple[str, ...] = ()
    empty_if: tuple[str, ...] = ()


@dataclass
class Log:
    """The requests, and the number of times that each question came."""

    requests: list[dict[str, Any]] = field(default_factory=list)
    asked: Counter[str] = field(default_factory=Counter)


@dataclass(frozen=True)
class Served:
    """A running server."""

    url: str
    log: Log


@contextmanager
def serve(
    script: Mapping[str, Sequence[Reply]], pages: Mapping[str, object] | None = None
) -> Iterator[Served]:
    """Serve while the block runs. The script has the replies to each question; the last one repeats.

    Args:
        script: mapping from questions to replies.
        pages: mapping from other paths to the JSON values at them.
    """
    log = Log()
    lock = threading.Lock()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            page = (pages or {}).get(self.path)
            body = json.dumps(_error(404) if page is None else page).encode()
            self.send_response(404 if page is None else 200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_POST(self) -> None:
            request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            if not self.path.endswith("/chat/completions"):
                self.do_GET()
                return
            question = _text(request["messages"][-1]["content"])
            with lock:
                replies = script[question]
                reply = replies[min(log.asked[question], len(replies) - 1)]
                log.asked[question] += 1
                log.requests.append(request)
            self._answer(reply, request)

        def _answer(self, reply: Reply, request: dict[str, Any]) -> None:
            time.sleep(reply.delay)
            if reply.reset:
                linger = struct.pack("ii", 1, 0)  # closing sends a reset
                self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
                self.connection.close()
                raise ConnectionResetError
            refused = any(name in request for name in reply.unless)
            status = 400 if refused else reply.status
            empty = any(name in request for name in reply.empty_if)
            body = json.dumps(_completion(reply, empty=empty) if status == 200 else _error(status)).encode()
            body = body if reply.body is None else reply.body.encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            if reply.retry_after is not None:
                self.send_header("Retry-After", reply.retry_after)
            self.end_headers()
            if reply.cut:
                self.wfile.write(body[: len(body) // 2])
                self.close_connection = True
            else:
                size = len(body) if not reply.drip else -(-len(body) // 10)
                for start in range(0, len(body), size):
                    self.wfile.write(body[start : start + size])
                    time.sleep(reply.drip)

        def log_message(self, format: str, *args: object) -> None:
            pass

        def handle(self) -> None:
            with contextlib.suppress(ConnectionError):  # the client has given up waiting
                super().handle()

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    server.block_on_close = False
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
    thread.start()
    try:
        yield Served(f"http://127.0.0.1:{server.server_address[1]}/v1", log)
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _text(content: str | list[dict[str, Any]]) -> str:
    """Return the text of a message without its pictures."""
    if isinstance(content, str):
        return content
    return "".join([part["text"] for part in content if part["type"] == "text"])


def _completion(reply: Reply, *, empty: bool) -> dict[str, Any]:
    message: dict[str, Any] = {"role": "assistant", "content": "" if empty else reply.text}
    if reply.reasoning is not None:
        message["reasoning_content"] = reply.reasoning
    message |= reply.message
    return {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 1,
        "model": "scripted",
        "choices": [{"index": 0, "message": message, "finish_reason": reply.finish, "logprobs": None}],
        "usage": reply.usage,
    }


def _error(status: int) -> dict[str, Any]:
    return {"error": {"message": f"scripted failure {status}", "type": "server_error", "code": None}}
