"""Templates: text files with ``$name`` where a text is to be put in.

The standard library's `string.Template` does it: answers are JSON and operators PDDL, so braces, brackets and
percent signs must mean themselves, and a template needs no loops, since every list comes as one text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Template

from eai.base.errors import InputError
from eai.base.files import files_below, read_content

_FOLDER = Path(__file__).parent / "templates"
_VARIANTS = "variants"


def template_names() -> frozenset[str]:
    """The names of all templates of the package, such as ``formats/transition_modeling.txt``."""
    names = (file.relative_to(_FOLDER).as_posix() for file in files_below(_FOLDER, "*.txt"))
    return frozenset(name for name in names if not name.startswith(f"{_VARIANTS}/"))


@cache
def _read_packaged(name: str, variant: str) -> str:
    """The text of a template of the package: of a variant, if that has one of this name."""
    file = _FOLDER / _VARIANTS / variant / name
    file = file if variant and file.is_file() else _FOLDER / name
    return file.read_text(encoding="utf-8").removesuffix("\n")


@dataclass(frozen=True, slots=True)
class Templates:
    """The templates of the package, with the user's own in place of single ones.

    Attributes:
        folder: the user's files under the names of ours; None if there are none.
        variant: the set of prompts whose wording is used; the plain one if it has no files of its own.
    """

    folder: Path | None = None
    variant: str = ""

    def read(self, name: str) -> str:
        """The text of a template, say ``action_sequencing.txt``, without the line break at its end.

        Raises:
            InputError: the user's file cannot be read.
        """
        own = self.read_own(name)
        return _read_packaged(name, self.variant) if own is None else own

    def read_own(self, name: str) -> str | None:
        """The user's own text of this name, or None.

        Raises:
            InputError: it cannot be read.
        """
        file = None if self.folder is None else self.folder / name
        if file is None or not file.exists():
            return None
        try:
            return read_content(file).decode().replace("\r\n", "\n").removesuffix("\n")
        except UnicodeDecodeError as error:
            raise InputError(f"{file}: cannot be read ({error})") from error

    def fill(self, name: str, values: Mapping[str, str]) -> str:
        """A template with its places filled.

        Raises:
            InputError: it names a place for which there is no text, or has a lone dollar sign.
        """
        try:
            return Template(self.read(name)).substitute(values)
        except KeyError as error:
            known = ", ".join(f"${place}" for place in values)
            raise InputError(f"{name}: ${error.args[0]} is none of {known}") from error
        except ValueError as error:
            raise InputError(f"{name}: {error}; a dollar sign is written as $$") from error
