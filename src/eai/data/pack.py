"""Packs: the files of the store, what archives each is made from, and how."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from eai.data.bundle import Bundle
from eai.data.progress import Report
from eai.data.source import Archive

Convert = Callable[[Mapping[str, Bundle], Report], dict[str, bytes]]
"""(archive's name -> its files, progress) -> member -> content. Same files, same bytes; or DataError."""


@dataclass(frozen=True, slots=True)
class Pack:
    """One file of the store.

    Attributes:
        name: the pack's name in `Store.open`.
        archives: what it is made from.
        convert: makes its members.
    """

    name: str
    archives: tuple[Archive, ...]
    convert: Convert

    @property
    def pins(self) -> dict[str, str]:
        """Requirement -> SHA-256 of its archives, as the pack's manifest records them."""
        return {archive.requirement: archive.sha256 for archive in self.archives}
