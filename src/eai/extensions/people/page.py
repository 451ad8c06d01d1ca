"""The page on which a person plays, served to this machine alone.

The page sends one line at a time and shows what it gets as text;
`eai.extensions.people.person` says what a line means.
A request under the name of another host is refused, and so is a command from the page of another site.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Generator, Iterator, Sequence
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from typing import Any, TypeAlias

from eai.agents.play import Play
from eai.base.errors import EaiError, InputError
from eai.base.json_value import Json
from eai.extensions.people.person import RULES, completions, enter
from eai.results.page import build_page, encode_for_script

MAX_BODY = 65_536
"""The longest request, in bytes."""

_PATIENCE = 10
"""How many seconds a request may take to arrive."""

_HOST = "127.0.0.1"
_HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}

Begun: TypeAlias = tuple[int, Play, Sequence[str]]
"""A task that is not over: its number, its episode, and what was observed in it so far."""

Keep: TypeAlias = Callable[[Play], None]
"""Takes an episode after each line."""


def _sitting(
    first: Begun, tasks: Iterator[Begun], total: int, keep: Keep
) -> Generator[dict[str, Json], str, None]:
    """All that the page shows of the tasks that a person plays; takes each line that it sends.

    Args:
        first: the first task that is not over.
        tasks: the others; any line after the end of a task leads to the next.
        total: how many tasks there are, those that are over included.
        keep: takes the episode.

    Raises:
        EaiError: the task cannot be shown in pictures, or the episode cannot be kept.
    """
    begun: Begun | None = first
    while begun is not None:
        (number, play, before), begun = begun, None
        log = [_entry(play, turn, told) for turn, told in enumerate(before)]
        shown = _shown(number, total, play, log)
        while begun is None:
            line = yield shown
            if line.strip() and not play.over:
                taken = len(play.turns)
                told = enter(play, line)
                keep(play)
                is_turn = len(play.turns) > taken
                log.append(_entry(play, taken, told) if is_turn else [line, told, "aside"])
                begun = next(tasks, None) if play.over else None
                shown = {**_shown(number, total, play, log), "last": play.over and begun is None}
        yield shown


def _shown(number: int, total: int, play: Play, log: Sequence[list[str]]) -> dict[str, Json]:
    return {
        "title": play.stage.benchmark.title or play.stage.benchmark.name,
        "number": number,
        "total": total,
        "rules": RULES,
        "opening": play.opening(),
        "pictures": [image.url for image in play.pictures()],
        "log": [*log],
        "at": f"{number}.{len(log)}",
        "words": [completions(play, ""), completions(play, "an action")],
        "over": play.over,
        "last": False,
    }


def _entry(play: Play, turn: int, told: str) -> list[str]:
    """Return a turn in the log: the command, the observation, and whether the action failed."""
    return [play.turns[turn].said, told, "failed" if play.failed[turn] else "done"]


class _Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: _Server
    timeout = _PATIENCE

    def do_GET(self) -> None:
        """Send the page."""
        if self._is_for_us():
            with self.server.lock:
                data = encode_for_script(self.server.shown)
            page = build_page("eai.extensions.people", "player", ("player.js",), data, sends=True)
            self._send("text/html", page)

    def do_POST(self) -> None:
        """Carry a line out, and send what the page shows then; the last one ends the server."""
        line = self._line() if self._is_for_us() else None
        if line is None:
            return
        server = self.server
        with server.lock:
            try:
                taken = server.error is None and self.path.removeprefix("/") == server.shown["at"]
                if taken:
                    server.shown = server.sitting.send(line)
                self._send("application/json", json.dumps({**server.shown, "taken": taken}))
            except EaiError as error:
                server.error = error
                self.send_error(HTTPStatus.INTERNAL_SERVER_ERROR, "it is not kept: the terminal says why")
            if server.error is not None or server.shown["last"]:
                server.shutdown()

    def _is_for_us(self) -> bool:
        """Whether a request is under a name of this machine; another one is refused."""
        is_ours = (self.headers["Host"] or "").partition(":")[0] in (_HOST, "localhost")
        if not is_ours:
            self.send_error(HTTPStatus.MISDIRECTED_REQUEST)
        return is_ours

    def _line(self) -> str | None:
        """The line that the page sends; None, and refused, if it comes from elsewhere or is too long."""
        length = self.headers["Content-Length"] or ""
        if self.headers["Origin"] != f"http://{self.headers['Host']}":
            self.send_error(HTTPStatus.FORBIDDEN)
        elif not re.fullmatch("[0-9]{1,5}", length) or int(length) > MAX_BODY:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        else:
            return self.rfile.read(int(length)).decode(errors="replace")
        return None

    def _send(self, kind: str, text: str) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {**_HEADERS, "Content-Type": f"{kind}; charset=utf-8"}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(text.encode())

    def log_message(self, *about: object) -> None:
        """Nothing: the terminal is for whoever began it."""


class _Server(ThreadingHTTPServer):
    """Serves a sitting; ``lock`` is for who uses it, and ``error`` why it ended before its end."""

    def __init__(self, port: int, sitting: Generator[dict[str, Json], str, None]) -> None:
        self.sitting, self.shown, self.lock = sitting, next(sitting), Lock()
        self.error: EaiError | None = None
        super().__init__((_HOST, port), _Handler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that has gone away is no error."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def serve_page(
    port: int, tasks: Iterator[Begun], total: int, keep: Keep, ready: Callable[[str], None]
) -> None:
    """Serve the page until all tasks are over.

    Args:
        port: where; 0 for any that is free.
        tasks: those that are not over.
        total: how many tasks there are, those that are over included.
        keep: takes an episode after each line.
        ready: takes the address, once the page can be opened.

    Raises:
        InputError: the port cannot be used, or an episode cannot be begun or kept.
    """
    first = next(tasks, None)
    if first is None:
        return
    try:
        server = _Server(port, _sitting(first, tasks, total, keep))
    except OSError as error:
        raise InputError(f"--page {port}: cannot be used ({error.strerror})") from error
    ready(f"http://{_HOST}:{server.server_port}/")
    try:
        server.serve_forever(poll_interval=0.1)
    finally:
        with server.lock:  # a line that is being carried out is kept
            server.server_close()
    if server.error is not None:
        raise server.error
