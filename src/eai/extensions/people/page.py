"""Serve the page on which a person plays, to browsers on this machine only.

The page sends one line at a time and shows the reply as text. `eai.extensions.people.person` interprets the
lines. Requests under the name of another host, and commands from pages of other sites, are refused.
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

from eai.agents.play import RecordedGame
from eai.base.errors import EaiError, InputError
from eai.base.json_value import Json
from eai.extensions.people.person import RULES, execute_line, list_possible_next_words
from eai.results.page import build_page, encode_for_script

MAX_REQUEST_BYTES = 65_536

_REQUEST_TIMEOUT = 10
"""Maximum time in seconds that a request may take to arrive."""

_HOST = "127.0.0.1"
_HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}

UnfinishedTask: TypeAlias = tuple[int, RecordedGame, Sequence[str]]
"""A task that is not over: its number, its episode, and the observations so far."""

SaveEpisode: TypeAlias = Callable[[RecordedGame], None]
"""Function that saves an episode. It is called after each line that the person enters."""


def _execute_typed_lines_and_yield_pages(
    first_task: UnfinishedTask,
    tasks: Iterator[UnfinishedTask],
    total_task_count: int,
    save_episode: SaveEpisode,
) -> Generator[dict[str, Json], str, None]:
    """Let a person play tasks in a browser, one after the other.

    Receive each typed line, execute it as a command, and yield the new content of the page. Any line after
    the end of a task begins the next task.

    Args:
        first_task: The first task that is not over.
        tasks: The other tasks that are not over.
        total_task_count: Number of all tasks, with those that are over.
        save_episode: Saves the episode.

    Raises:
        EaiError: The task cannot be shown in pictures, or the episode cannot be saved.
    """
    task: UnfinishedTask | None = first_task
    while task is not None:
        (number, play, observations), task = task, None
        log = [_make_log_entry(play, turn, text) for turn, text in enumerate(observations)]
        content = _make_page_content(number, total_task_count, play, log)
        while task is None:
            line = yield content
            if line.strip() and not play.is_over:
                turn = len(play.turns)
                reply = execute_line(play, line)
                save_episode(play)
                is_turn = len(play.turns) > turn
                log.append(_make_log_entry(play, turn, reply) if is_turn else [line, reply, "aside"])
                task = next(tasks, None) if play.is_over else None
                content = {
                    **_make_page_content(number, total_task_count, play, log),
                    "last": play.is_over and task is None,
                }
        yield content


def _make_page_content(
    number: int, total: int, play: RecordedGame, log: Sequence[list[str]]
) -> dict[str, Json]:
    return {
        "title": play.setup.benchmark.title or play.setup.benchmark.name,
        "number": number,
        "total": total,
        "rules": RULES,
        "opening": play.write_first_observation(),
        "pictures": [image.data_url for image in play.draw_pictures_of_current_world()],
        "log": [*log],
        "at": f"{number}.{len(log)}",
        "words": [list_possible_next_words(play, ""), list_possible_next_words(play, "an action")],
        "over": play.is_over,
        "last": False,
    }


def _make_log_entry(play: RecordedGame, turn: int, observation: str) -> list[str]:
    """Return the command, the observation and the result ("failed" or "done") of a turn of an episode."""
    return [play.turns[turn].said, observation, "failed" if play.failed[turn] else "done"]


class _PlayRequestHandler(BaseHTTPRequestHandler):
    """Answers one HTTP request of the person's browser."""

    server: _PlayPageServer
    timeout = _REQUEST_TIMEOUT

    def do_GET(self) -> None:
        """Send the page."""
        if self._is_request_for_this_host():
            with self.server.lock:
                data = encode_for_script(self.server.content)
            page = build_page("eai.extensions.people", "player", ("player.js",), data, sends_requests=True)
            self._send_response("text/html", page)

    def do_POST(self) -> None:
        """Execute the command that the page sent, and send the page's new content.

        A command is ignored if the page shows an earlier turn. The server stops after the last task, or if an
        episode cannot be saved.
        """
        line = self._read_line() if self._is_request_for_this_host() else None
        if line is None:
            return
        server = self.server
        with server.lock:
            try:
                is_current = server.error is None and self.path.removeprefix("/") == server.content["at"]
                if is_current:
                    server.content = server.tasks.send(line)
                self._send_response("application/json", json.dumps({**server.content, "taken": is_current}))
            except EaiError as error:
                server.error = error
                self.send_error(HTTPStatus.INTERNAL_SERVER_ERROR, "not saved: see the error in the terminal")
            if server.error is not None or server.content["last"]:
                server.shutdown()

    def _is_request_for_this_host(self) -> bool:
        """Whether a request names this machine as its host. If not, send an error."""
        is_own = (self.headers["Host"] or "").partition(":")[0] in (_HOST, "localhost")
        if not is_own:
            self.send_error(HTTPStatus.MISDIRECTED_REQUEST)
        return is_own

    def _read_line(self) -> str | None:
        """Return the line that the page sent; send an error and return None if the request is refused."""
        length = self.headers["Content-Length"] or ""
        if self.headers["Origin"] != f"http://{self.headers['Host']}":
            self.send_error(HTTPStatus.FORBIDDEN)
        elif not re.fullmatch("[0-9]{1,5}", length) or int(length) > MAX_REQUEST_BYTES:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        else:
            return self.rfile.read(int(length)).decode(errors="replace")
        return None

    def _send_response(self, kind: str, text: str) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {**_HEADERS, "Content-Type": f"{kind}; charset=utf-8"}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(text.encode())

    def log_message(self, *about: object) -> None:
        """Log nothing, because the terminal belongs to the person who plays."""


class _PlayPageServer(ThreadingHTTPServer):
    """Serves the page on which a person plays tasks.

    Attributes:
        tasks: Generator that takes each command line and yields the page's new content
            (`_execute_typed_lines_and_yield_pages`).
        content: Current content of the page.
        lock: Held while `tasks` or `content` is used.
        error: Error that ended the server early, or None.
    """

    def __init__(self, port: int, tasks: Generator[dict[str, Json], str, None]) -> None:
        self.tasks, self.content, self.lock = tasks, next(tasks), Lock()
        self.error: EaiError | None = None
        super().__init__((_HOST, port), _PlayRequestHandler)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a browser that closed its connection."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def serve_page(
    port: int, tasks: Iterator[UnfinishedTask], total: int, save: SaveEpisode, ready: Callable[[str], None]
) -> None:
    """Serve the page until all tasks are over.

    Args:
        port: Port number; 0 for any free port.
        tasks: The tasks that are not over.
        total: Number of all tasks, with those that are over.
        save: Saves an episode; called after each line that the person enters.
        ready: Function that is called with the address of the page as soon as browsers can open the page.

    Raises:
        InputError: The port cannot be used, or an episode cannot be begun or saved.
    """
    first = next(tasks, None)
    if first is None:
        return
    try:
        server = _PlayPageServer(port, _execute_typed_lines_and_yield_pages(first, tasks, total, save))
    except OSError as error:
        raise InputError(
            f"--page {port}: cannot be used ({error.strerror}); give another port, or 0 for any free port"
        ) from error
    ready(f"http://{_HOST}:{server.server_port}/")
    try:
        server.serve_forever(poll_interval=0.1)
    finally:
        with server.lock:  # wait, because another thread may be saving a line
            server.server_close()
    if server.error is not None:
        raise server.error
