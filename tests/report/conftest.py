"""The command line, as the tests of commands run it."""

from __future__ import annotations

from cli.conftest import eai

__all__ = ["eai"]
