"""Pages in one file, with style, program and data in it: they open from disk and reach for nothing."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from importlib import resources

from eai.base.json_value import Json


def build_page(package: str, folder: str, scripts: Sequence[str], data: str, *, sends: bool = False) -> str:
    """The page of a folder with ``page.html``, from its body on, ``style.css`` and scripts.

    Its policy allows its own style and program, by digest, and nothing else: no other script, and no request
    but to the server that it comes from, if it ``sends`` any and shows pictures of its answers.

    Args:
        package: the package that the folder is in.
        folder: the folder, which is also what the page is called.
        scripts: the parts of the program, in the order in which they need each other.
        data: what the page is about: from `for_script`, or as HTML.
        sends: whether it sends requests to where it comes from.
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
            *(["connect-src 'self'", "img-src data:"] if sends else []),
        )
    )
    parts = {"policy": policy, "name": folder, "style": style, "program": program, "data": data}
    page = (resources.files("eai.results") / "page.html").read_text(encoding="utf-8") + read("page.html")
    for name, text in parts.items():
        before, _, after = page.partition(f"{{{{{name}}}}}")
        page = f"{before}{text}{after}"
    return page


_COMPACT = json.JSONEncoder(separators=(",", ":"))


def encode_for_script(content: Json) -> str:
    """JSON in ASCII without ``<``, ``>`` and ``&``, so that no text in it can end a script element."""
    text = _COMPACT.encode(content)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
