"""Writes docs/api.md from the docstrings of the public names: `python tools/api_page.py`."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator
from enum import Enum
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "api.md"
MODULES = ("eai", "eai.world")
HEAD = """\
# API

On this page you can look up what `import eai` and `import eai.world` offer.
`python tools/api_page.py` writes it from the docstrings.
"""
SECTION = re.compile(r"^(Args|Attributes|Raises|Returns|Yields):$")
ENTRY = re.compile(r"^    (\*{0,2}\w+): (.*)$")


def page() -> str:
    """The whole page."""
    return HEAD + "".join(part for module in MODULES for part in _module(module))


def _module(name: str) -> Iterator[str]:
    module = importlib.import_module(name)
    yield f"\n## {name}\n\n{_text(inspect.getdoc(module) or '')}\n"
    for each in sorted(module.__all__, key=str.lower):
        yield _entry(each, getattr(module, each))


def _entry(name: str, value: object) -> str:
    """What there is to say of one public name."""
    if not (inspect.isclass(value) or inspect.isfunction(value)):
        return f"\n### {name}\n\n`{value!r}`\n"
    doc = _text(inspect.getdoc(value) or "")
    methods = "".join(_methods(value)) if inspect.isclass(value) else ""
    return f"\n### {name}\n\n`{name}{_signature(value)}`\n\n{doc}\n{methods}"


def _signature(value: object) -> str:
    if inspect.isclass(value) and issubclass(value, Exception | Enum):
        return ""
    if not callable(value):
        return ""
    text = re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(inspect.signature(value)))
    text = re.sub(r"\b[a-z]\.(?=[A-Z])", "", text)  # the aliases of modules
    return re.sub(r"<factory>|<function \S+ at 0x\w+>", "...", text)


def _methods(cls: type) -> Iterator[str]:
    for name, member in vars(cls).items():
        inner = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
        if name.startswith("_") or not inspect.isfunction(inner):
            continue
        first = (inspect.getdoc(inner) or "").partition("\n\n")[0].replace("\n", " ")
        call = name if isinstance(member, property) else f"{name}{_signature(inner)}"
        yield f"\n- `{call}`: {first}"
    yield "\n"


def _text(doc: str) -> str:
    """A docstring as Markdown: sections as lists, code blocks kept."""
    lines: list[str] = []
    for line in doc.splitlines():
        section, entry = SECTION.match(line), ENTRY.match(line)
        if section:
            lines += [f"**{section[1]}**", ""]
        elif entry:
            lines.append(f"- `{entry[1]}`: {entry[2]}")
        else:
            lines.append(line.replace("``", "`"))
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
