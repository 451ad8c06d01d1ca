"""Pages in one file, with style, program and data in it: they open from disk and reach for nothing."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from importlib import resources

from eai.abilities.verdict import Json


def build_page(package: str, folder: str, scripts: Sequence[str], data: str) -> str:
    """The page of a folder with ``page.html``, ``style.css`` and scripts.

    Its policy allows its own style and program, by digest, and nothing else: no request, no other script.

    Args:
        package: the package that the folder is in.
        folder: the folder.
        scripts: the parts of the program, in the order in which they need each other.
        data: from `for_script`.
    """

    def read(name: str) -> str:
        return (resources.files(package) / folder / name).read_text(encoding="utf-8")

    style = read("style.css")
    program = "(() => {\n'use strict';\n" + "\n".join(map(read, scripts)) + "\n})();\n"
    policy = "; ".join(
        (
            "default-src 'none'",
            f"style-src '{_digest(style)}'",
            f"script-src '{_digest(program)}'",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    page = read("page.html")
    for name, text in (("policy", policy), ("style", style), ("program", program), ("data", data)):
        before, _, after = page.partition(f"{{{{{name}}}}}")
        page = f"{before}{text}{after}"
    return page


def for_script(content: Json) -> str:
    """JSON in ASCII without ``<``, ``>`` and ``&``, so that no text in it can end a script element."""
    text = json.dumps(content, ensure_ascii=True, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
