"""A real browser for tests of pages: Debian's Chromium, driven by Playwright, without a network."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium")
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine: apt install chromium"
)
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@contextmanager
def started_browser() -> Iterator[Any]:
    """Yield a browser, or skip the test if Playwright is not installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield started
        started.close()


def open_explorer(page: Any, address: str) -> None:
    """Open an address of the explorer anew, and wait until the page shows an answer."""
    page.goto("about:blank")
    page.goto(address)
    wait_for_answer(page)


def wait_for_answer(page: Any) -> None:
    """Wait until the explorer has read the chosen answer."""
    page.locator('#detail[aria-busy="false"]').wait_for(state="attached")


@contextmanager
def quiet_page(browser: Any) -> Iterator[Any]:
    """Yield a page that must log nothing to the console, raise no error and request nothing from outside."""
    context = browser.new_context(viewport={"width": 1400, "height": 900}, accept_downloads=True)
    opened = context.new_page()
    trouble: list[str] = []
    opened.on("console", lambda message: trouble.append(message.text))
    opened.on("pageerror", lambda error: trouble.append(str(error)))
    opened.on(
        "request",
        lambda request: None if request.url.startswith(("file:", "blob:")) else trouble.append(request.url),
    )
    yield opened
    context.close()
    assert [what for what in trouble if not what.startswith("file:")] == []
