"""Frozen values are copied and pickled as the arguments that make them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def fields_in_order(value: Any) -> tuple[object, ...]:
    """The fields of a dataclass, which are the arguments that make it."""
    return tuple([getattr(value, name) for name in value.__dataclass_fields__])


class Frozen:
    """A frozen dataclass that is copied and pickled by making it again.

    Compiled, it could not be otherwise: its attributes would be set one by one, which a frozen one forbids.
    """

    __slots__ = ()

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return type(self), fields_in_order(self)
