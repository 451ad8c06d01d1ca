"""Answers at which the reference ends its whole run."""

from __future__ import annotations

from eai.abilities.unreadable import Unreadable


class Aborting(Unreadable):
    """Why an answer cannot be read, where the reference does not count it as unread but stops."""

    __slots__ = ()
