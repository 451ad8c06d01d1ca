"""Arguments that cannot be used, as Inspect's command line, which is click's, tells them: in one line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import click

from eai.errors import InputError


class _RefusalError(InputError, click.ClickException):
    """An argument of a task or a model that cannot be used.

    Args:
        message: which, and what was expected.
    """

    def __init__(self, message: str) -> None:
        click.ClickException.__init__(self, message)


@contextmanager
def refusing() -> Iterator[None]:
    """Input that cannot be used ends what is in the block as a `_RefusalError`."""
    try:
        yield
    except InputError as error:
        raise _RefusalError(str(error)) from error
