"""``eai new``: write a small example domain, to be changed into a domain of your own."""

from __future__ import annotations

from importlib.resources import files
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path

from eai.base.errors import InputError
from eai.base.files import write_files_atomically
from eai.cli.console import print_result
from eai.cli.options import AsJson

_FILES = {"{name}.py": "domain.txt", "README.md": "readme.txt"}
"""Templates of a new domain, by file name."""


def new(name: str, as_json: AsJson = False) -> None:
    """Write a small domain that runs: a folder NAME with its declaration and two tasks in NAME.py.

    Example: eai new warehouse

    Options:
        name: Name of the domain and of its folder, a valid Python name.
    """
    if not name.isidentifier() or iskeyword(name):
        raise InputError(f"{name}: expected a name in Python: letters, digits and underscores")
    folder = Path(name)
    if folder.exists():
        raise InputError(f"{name}: expected a new folder; this one is there already")
    if find_spec(name) is not None:
        raise InputError(f"{name}: expected another name; a Python module has this name")
    texts = files(__package__) / "templates"
    made = {
        folder / file.format(name=name): (texts / text).read_text(encoding="utf-8").replace("NAME", name)
        for file, text in _FILES.items()
    }
    write_files_atomically({path: text.encode() for path, text in made.items()})
    lines = [f"{', '.join(map(str, made))} written", f"next: cd {name}; eai check {name}:{name}"]
    print_result(*lines, value={"files": [*map(str, made)], "domain": f"{name}:{name}"}, as_json=as_json)
