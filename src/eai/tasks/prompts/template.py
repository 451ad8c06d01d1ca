"""Templates: text files in which a text replaces each ``$name``.

They use `string.Template` of the standard library. Answers are JSON and operators are PDDL, so braces,
brackets and percent signs must stand for themselves. Templates need no loops, because each list comes as one
text.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Template
from typing import TypeAlias

from eai.base.errors import InputError
from eai.base.files import decode_text, find_files_below, read_content

_FOLDER = Path(__file__).parent / "templates"
_VARIANTS = "variants"


def list_template_names() -> frozenset[str]:
    """Return the names of all packaged templates, such as ``formats/transition_modeling.txt``."""
    names = (file.relative_to(_FOLDER).as_posix() for file in find_files_below(_FOLDER, "*.txt"))
    return frozenset(name for name in names if not name.startswith(f"{_VARIANTS}/"))


@cache
def _read_packaged_template(name: str, variant: str) -> str:
    """Return the text of a template of this package, in the wording `variant` if there is one."""
    file = _FOLDER / _VARIANTS / variant / name
    file = file if variant and file.is_file() else _FOLDER / name
    return file.read_text(encoding="utf-8").removesuffix("\n")


Text: TypeAlias = str | Callable[[], str]
"""The text that replaces a placeholder, or a function that returns this text."""


class _PlaceholderTexts(dict[str, Text]):
    """Texts that replace placeholders."""

    def __getitem__(self, name: str) -> str:
        text = super().__getitem__(name)
        return text if isinstance(text, str) else text()


@dataclass(frozen=True, slots=True)
class PromptTemplates:
    """The templates in this package. The user may replace any template.

    Attributes:
        folder: the folder of the user's templates, named like ours; None if the user has no templates.
        variant: name of a set of packaged templates with another wording; empty for the usual set. Templates
            that the named set lacks are taken from the usual set.
    """

    folder: Path | None = None
    variant: str = ""

    def read(self, name: str) -> str:
        """Return the text of a template, for example ``action_sequencing.txt``, without the last line break.

        If the user has a template of this name, it is returned instead of the packaged template.

        Raises:
            InputError: the file of the user's template cannot be read.
        """
        own = self.read_user_template(name)
        return _read_packaged_template(name, self.variant) if own is None else own

    def read_user_template(self, name: str) -> str | None:
        """Return the user's template of this name, or None if it does not exist.

        Raises:
            InputError: the file cannot be read.
        """
        file = None if self.folder is None else self.folder / name
        if file is None or not file.exists():
            return None
        return decode_text(file, read_content(file)).replace("\r\n", "\n").removesuffix("\n")

    def fill_template(self, name: str, values: Mapping[str, Text]) -> str:
        """Return a template with its placeholders replaced by texts.

        If a function returns the text of a placeholder, it is called only if the template has this
        placeholder.

        Raises:
            InputError: a placeholder has no text, or a dollar sign stands alone.
        """
        try:
            return Template(self.read(name)).substitute(_PlaceholderTexts(values))
        except KeyError as error:
            placeholders = ", ".join(f"${placeholder}" for placeholder in values)
            raise InputError(
                f"{name}: unknown placeholder ${error.args[0]}: expected one of {placeholders}"
            ) from error
        except ValueError as error:
            raise InputError(f"{name}: {error}; a dollar sign is written as $$") from error
