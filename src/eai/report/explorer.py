"""The explorer: one HTML file with everything in it, which opens from disk and reaches for nothing."""

from __future__ import annotations

from eai.results.page import build_page

SCRIPTS = (
    "data.js",
    "dom.js",
    "state.js",
    "filters.js",
    "list.js",
    "scene.js",
    "replay.js",
    "operators.js",
    "detail.js",
    "compare.js",
    "main.js",
)
"""The parts of the program, in the order in which they need each other."""


def explorer_html(data: str) -> str:
    """The page.

    Args:
        data: from `explorer_data.ExplorerData.to_json`.
    """
    return build_page("eai.report", "explorer", SCRIPTS, data)
