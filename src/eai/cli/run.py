"""``eai run``: obtain a model's answers and score them."""

from __future__ import annotations


def run() -> None:
    """Obtain a model's answers and score them."""
    raise NotImplementedError
