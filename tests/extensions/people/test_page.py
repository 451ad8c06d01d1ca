"""A person plays on a page: the same episodes as in the terminal, and nobody else gets a word in."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any, NamedTuple

import pytest

from agents.switches import WON
from browsing import needs_browser
from eai.agents.play import RecordedGame
from eai.base.errors import EaiError, InputError
from eai.extensions.people.command import play
from eai.extensions.people.page import MAX_REQUEST_BYTES
from eai.tasks.prompts.prompt import Image

DOMAIN = "agents.switches:SWITCHES"
SCRIPT = "<script>alert('</script>')</script>"


REFUSED: tuple[tuple[str, dict[str, str], int], ...] = (
    ("GET", {"Host": "evil.example"}, 421),
    ("GET", {"Host": "127.0.0.1.evil.example:80"}, 421),
    ("GET", {"Host": ""}, 421),
    ("POST", {"Host": "evil.example", "Origin": "http://evil.example"}, 421),
    ("POST", {"Origin": "http://evil.example"}, 403),
    ("POST", {"Origin": "null"}, 403),
    ("POST", {"Origin": ""}, 403),
    ("POST", {"Origin": "http://127.0.0.1:1"}, 403),
    ("POST", {"Origin": "https://127.0.0.1"}, 403),
    ("POST", {"Content-Length": str(MAX_REQUEST_BYTES + 1)}, 413),
    ("POST", {"Content-Length": "9" * 5000}, 413),
    ("POST", {"Content-Length": "-1"}, 413),
    ("POST", {"Content-Length": "", "Transfer-Encoding": "chunked"}, 413),
    ("PUT", {}, 501),
    ("OPTIONS", {}, 501),
)
"""Requests of others: method, what differs from the page's headers, and how they are answered."""


class Sitting(NamedTuple):
    """A command under way: where its page is, and what it ends with."""

    port: int
    out: Path
    ended: Callable[[], EaiError | None]

    def ask(self, method: str, path: str = "/", body: str | bytes = "", **headers: str) -> HTTPResponse:
        """A request as the page sends it, but for these headers."""
        host = f"127.0.0.1:{self.port}"
        connection = HTTPConnection(host, timeout=20)
        connection.request(method, path, body, {"Host": host, "Origin": f"http://{host}", **headers})
        return connection.getresponse()

    def shown(self) -> dict[str, Any]:
        """What the page shows when it is loaded."""
        page = self.ask("GET").read().decode()
        state: dict[str, Any] = json.loads(page.partition('id="data">')[2].partition("</script>")[0])
        return state

    def send(self, line: str, at: str | None = None) -> dict[str, Any]:
        """Send a line; returns what the page shows then."""
        reply = self.ask("POST", f"/{at or self.shown()['at']}", line)
        assert reply.status == 200
        state: dict[str, Any] = json.loads(reply.read())
        return state

    def said(self) -> list[list[str]]:
        """The commands in the file, by task."""
        rows = json.loads(self.out.read_bytes())
        return [[turn["said"] for turn in json.loads(row["llm_output"])["turns"]] for row in rows]


@pytest.fixture
def sit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Sitting]]:
    """Begins the command for some tasks, all of which are to be over at the end of the test."""
    threads = []

    def begin(tasks: str = "both", name: str = "ann") -> Sitting:
        told: Queue[str] = Queue()
        errors: list[EaiError] = []
        monkeypatch.setattr("eai.extensions.people.command.print_note", told.put)
        out = tmp_path / f"{name}_outputs.json"

        def run() -> None:
            try:
                play(DOMAIN, tasks=tasks, page=0, out=out)
            except EaiError as error:
                errors.append(error)

        thread = Thread(target=run, daemon=True)
        thread.start()
        threads.append(thread)

        def ended() -> EaiError | None:
            thread.join(20)
            assert not thread.is_alive()
            return errors[0] if errors else None

        port = int(told.get(timeout=20).rpartition(":")[2].removesuffix("/"))
        return Sitting(port, out, ended)

    yield begin
    for thread in threads:
        thread.join(20)
        assert not thread.is_alive()


def test_a_task_that_is_played_to_its_end_is_the_episode_of_the_terminal(
    sit: Callable[..., Sitting], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sitting = sit("both,half")
    shown = sitting.shown()
    assert (shown["number"], shown["total"], shown["over"]) == (1, 2, False)
    assert "Switch both on." in shown["opening"]
    for line in (*WON, "done"):
        shown = sitting.send(line)
    assert (shown["over"], shown["last"], shown["log"][-1][0]) == (True, False, "DONE")
    assert sitting.said() == [[*WON, "DONE"]]
    shown = sitting.send("")
    assert (shown["number"], shown["log"]) == (2, [])
    assert sitting.send("done")["last"]
    assert sitting.ended() is None
    typed = iter([*WON, "done", "done"])
    monkeypatch.setattr("builtins.input", lambda _: next(typed))
    terminal = tmp_path / "bob_outputs.json"
    play(DOMAIN, tasks="both,half", out=terminal)
    here, there = (
        [(row["identifier"], row["llm_output"]) for row in json.loads(path.read_bytes())]
        for path in (sitting.out, terminal)
    )
    assert here == there


def test_each_line_is_kept_at_once_and_the_page_shows_it_when_it_is_loaded_again(
    sit: Callable[..., Sitting],
) -> None:
    sitting = sit()
    lines = ("press lamp", "press torch", "press lamb", "? box", "", "go hall", SCRIPT)
    for line in lines:
        shown = sitting.send(line)
    marks = [(said, kind) for said, _, kind in shown["log"]]
    assert marks == [
        ("PRESS(lamp)", "done"),
        ("PRESS(torch)", "failed"),
        ("PRESS(lamb)", "failed"),
        ("? box", "aside"),
        ("GO(hall)", "failed"),
        (SCRIPT, "failed"),
    ]
    assert sitting.said() == [[said for said, kind in marks if kind != "aside"]]
    assert "(did you mean lamp?)" in shown["log"][2][1]
    del shown["taken"]
    assert sitting.shown() == shown
    assert shown["words"] == [
        ["GO", "OPEN", "PRESS", "WAVE", "DONE", "LOOK"],
        ["robot", "hall", "shed", "lamp"],
    ]
    assert "<script>alert" not in sitting.ask("GET").read().decode()
    sitting.send("DONE")


def test_the_same_command_goes_on_within_a_task(sit: Callable[..., Sitting]) -> None:
    first = sit("both,half")
    told = first.send(WON[0])["log"]
    first.out.rename(first.out.with_name("meanwhile_outputs.json"))
    refused = first.ask("POST", f"/{first.shown()['at']}", "WAVE")
    assert refused.status == 500
    assert "another program has written this file" in str(first.ended())
    first.out.with_name("meanwhile_outputs.json").rename(first.out)
    second = sit("both,half")
    assert second.shown()["log"] == told
    for line in (*WON[1:], "DONE", "", "DONE"):
        second.send(line)
    assert second.said() == [[*WON, "DONE"], ["DONE"]]


def test_a_page_that_is_behind_does_nothing(sit: Callable[..., Sitting]) -> None:
    sitting = sit()
    before = sitting.shown()["at"]
    assert sitting.send(WON[0], before)["taken"]
    late = sitting.send("WAVE", before)
    assert (late["taken"], [said for said, _, _ in late["log"]]) == (False, [WON[0]])
    assert not sitting.send("WAVE", "x")["taken"]
    sitting.send("DONE")
    assert sitting.said() == [[WON[0], "DONE"]]


def test_requests_that_are_not_the_page_s_are_refused(sit: Callable[..., Sitting]) -> None:
    sitting = sit()
    at = sitting.shown()["at"]
    for method, headers, status in REFUSED:
        assert (sitting.ask(method, f"/{at}", "GO(shed)", **headers).status, headers) == (status, headers)
    assert not sitting.out.exists()
    sitting.send("DONE", at)


def test_other_bytes_are_a_command_like_any_other(sit: Callable[..., Sitting]) -> None:
    sitting = sit()
    for body in (b"\xff\x00 GO", b"GO(" * 20_000, "\ud83d\ude00".encode("utf-16", "surrogatepass")):
        reply = sitting.ask("POST", f"/{sitting.shown()['at']}", body)
        assert json.loads(reply.read())["log"][-1][2] == "failed"
    sitting.send("DONE")


def test_a_page_cannot_be_framed_or_kept(sit: Callable[..., Sitting]) -> None:
    sitting = sit()
    reply = sitting.ask("GET")
    assert reply.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert reply.headers["Cache-Control"] == "no-store"
    page = reply.read().decode()
    assert "default-src 'none'" in page
    assert "connect-src 'self'" in page
    sitting.send("DONE")


def test_it_listens_to_this_machine_alone_and_says_when_a_port_is_taken(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"--page {port}: cannot be used"):
            play(DOMAIN, tasks="both", page=port, out=tmp_path / "ann_outputs.json")


PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63606060000000040001"
    "f61738550000000049454e44ae426082"
)


@needs_browser
def test_pictures_are_shown_where_turns_are_told_by_them(
    sit: Callable[..., Sitting], browser: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        RecordedGame,
        "draw_pictures_of_current_world",
        lambda play: () if play.is_over else (Image("image/png", PIXEL),),
    )
    sitting = sit()
    page = browser.new_page()
    page.goto(f"http://127.0.0.1:{sitting.port}/")
    picture = page.get_by_alt_text("Picture 1 of the world now")
    assert picture.evaluate("it => it.decode().then(() => it.naturalWidth)") == 1
    page.get_by_label("Your next action").fill("DONE")
    page.keyboard.press("Enter")
    page.get_by_text("All tasks are over.").wait_for()
    assert picture.count() == 0
    page.close()


@needs_browser
def test_a_person_plays_in_a_browser(sit: Callable[..., Sitting], browser: Any) -> None:
    sitting = sit("both,half")
    page = browser.new_context(color_scheme="dark").new_page()
    trouble: list[str] = []
    page.on("pageerror", lambda error: trouble.append(str(error)))
    page.on("console", lambda message: trouble.append(message.text))
    page.on("dialog", lambda dialog: dialog.accept())
    page.goto(f"http://localhost:{sitting.port}/")
    field, log = page.get_by_label("Your next action"), page.get_by_role("log")
    page.keyboard.type("press l")
    offered = page.locator("#words option").evaluate_all("them => them.map(it => it.value)")
    assert offered == ["press hall", "press lamp"]
    page.keyboard.type("amp")
    page.keyboard.press("Enter")
    for number, line in enumerate((SCRIPT, *WON[1:]), 2):
        log.locator("li").nth(number - 2).wait_for()
        assert (field.input_value(), field.evaluate("it => it === document.activeElement")) == ("", True)
        page.keyboard.type(line)
        page.keyboard.press("Enter")
    log.locator("li").nth(4).wait_for()
    assert log.locator(".failed .said").all_inner_texts() == [f"{SCRIPT}failed"]
    page.get_by_role("button", name="What is possible?").click()
    log.get_by_text("GO: hall").wait_for()
    page.reload()
    assert log.locator("li").count() == 6
    page.get_by_role("button", name="The task is done").click()
    page.get_by_text("This task is over.").wait_for()
    page.keyboard.press("Enter")
    page.get_by_text("Task 2 of 2").wait_for()
    assert (log.locator("li").count(), trouble) == (0, [])
    page.keyboard.type("DONE")
    page.keyboard.press("Enter")
    page.get_by_text("All tasks are over.").wait_for()
    assert sitting.said()[0] == [WON[0], SCRIPT, *WON[1:], "DONE"]
    page.context.close()
