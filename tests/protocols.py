"""The reference's protocol in tests outside its folder, which are skipped where it is not there."""

from __future__ import annotations

from typing import Any

import pytest


def of_reference(module: str) -> Any:
    """A module of the reference's protocol.

    Raises:
        Skipped: it is not there.
    """
    return pytest.importorskip(
        f"eai.extensions.reference.{module}", reason="the reference's protocol is not there"
    )
