"""Builds HTML pages, each one file with its style, program and data, so that a page needs no network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from importlib import resources

from eai.base.json_value import Json


def build_page(
    package: str, folder: str, scripts: Sequence[str], data: str, *, sends_requests: bool = False
) -> str:
    """Return the page of a folder, made from ``page.html`` (its body), ``style.css`` and scripts.

    The page's content security policy allows only its own style and program, by digest. A page that sends
    requests may also reach its own server and show pictures given as data URLs.

    Args:
        package: the package of the folder.
        folder: the folder, which is also the page's name.
        scripts: the files of the program, in the order in which they depend on each other.
        data: the content of the page: from `encode_for_script`, or as HTML.
        sends_requests: whether the page sends requests to its server.
    """

    def read_resource(name: str) -> str:
        return (resources.files(package) / folder / name).read_text(encoding="utf-8")

    style = read_resource("style.css")
    program = "(async () => {\n'use strict';\n" + "\n".join(map(read_resource, scripts)) + "\n})();\n"
    policy = "; ".join(
        (
            "default-src 'none'",
            f"style-src '{_hash_for_content_policy(style)}'",
            f"script-src '{_hash_for_content_policy(program)}'",
            "base-uri 'none'",
            "form-action 'none'",
            *(["connect-src 'self'", "img-src data:"] if sends_requests else []),
        )
    )
    parts = {"policy": policy, "name": folder, "style": style, "program": program, "data": data}
    page = (resources.files("eai.results") / "page.html").read_text(encoding="utf-8") + read_resource(
        "page.html"
    )
    for name, text in parts.items():
        before, _, after = page.partition(f"{{{{{name}}}}}")
        page = f"{before}{text}{after}"
    return page


_COMPACT = json.JSONEncoder(separators=(",", ":"))


def encode_for_script(content: Json) -> str:
    """Return JSON in ASCII without ``<``, ``>`` and ``&``, so that no text in it can end a script element."""
    text = _COMPACT.encode(content)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _hash_for_content_policy(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
