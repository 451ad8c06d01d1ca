"""Files of specifications: TOML, as ``eai run FILE.toml`` takes it and writes it beside its results."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from itertools import count
from pathlib import Path

from pydantic import JsonValue

from eai.data.files import write_whole
from eai.errors import InputError
from eai.run.spec import RunSpec

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that need no quotes."""


def read_tables(file: Path) -> dict[str, object]:
    """The tables of a file.

    Raises:
        InputError: it cannot be read, or is no TOML.
    """
    try:
        return tomllib.loads(file.read_text("utf-8"))
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror})") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{file}: expected TOML; {error}") from error


def save(spec: RunSpec, folder: Path) -> Path:
    """Write a specification to ``run.toml``, or to ``run-2.toml`` and so on where other runs have theirs.

    Raises:
        InputError: the folder cannot be written.
    """
    content = "\n".join(
        "".join([f"[{name}]\n", *(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())])
        for name, table in spec.tables.items()
    ).encode("utf-8", "backslashreplace")
    files = (folder / f"run{'' if number == 1 else f'-{number}'}.toml" for number in count(1))
    file = next(each for each in files if not each.is_file() or each.read_bytes() == content)
    write_whole({file: content})
    return file


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: JsonValue) -> str:
    """A value in TOML, which has no null: members without a value are left out."""
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        inner = [f"{_key(name)} = {_value(each)}" for name, each in value.items() if each is not None]
        return f"{{ {', '.join(inner)} }}" if inner else "{}"
    if isinstance(value, list):
        return f"[{', '.join(_value(each) for each in value if each is not None)}]"
    return str(value).lower() if isinstance(value, bool) else repr(value)
