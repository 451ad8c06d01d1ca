"""The explorer: one HTML file with everything in it, which opens from disk and reaches for nothing."""

from __future__ import annotations

import base64
import hashlib
from importlib import resources

SCRIPTS = (
    "data.js",
    "dom.js",
    "state.js",
    "filters.js",
    "list.js",
    "replay.js",
    "operators.js",
    "detail.js",
    "compare.js",
    "main.js",
)
"""The parts of the program, in the order in which they need each other."""

_FOLDER = "explorer"


def explorer_html(data: str) -> str:
    """The page.

    Its policy allows its own style and program, by digest, and nothing else: no request, no other script.

    Args:
        data: from `explorer_data.ExplorerData.to_json`.
    """
    style = _read("style.css")
    program = "(() => {\n'use strict';\n" + "\n".join(_read(name) for name in SCRIPTS) + "\n})();\n"
    policy = "; ".join(
        (
            "default-src 'none'",
            f"style-src '{_digest(style)}'",
            f"script-src '{_digest(program)}'",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    page = _read("page.html")
    for name, text in (("policy", policy), ("style", style), ("program", program), ("data", data)):
        before, _, after = page.partition(f"{{{{{name}}}}}")
        page = f"{before}{text}{after}"
    return page


def _read(name: str) -> str:
    return (resources.files("eai.report") / _FOLDER / name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
