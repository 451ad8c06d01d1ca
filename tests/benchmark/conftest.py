"""The fixtures of the made-up data set."""

from __future__ import annotations

from households.published import index, packs, store, wheel

__all__ = ["index", "packs", "store", "wheel"]
