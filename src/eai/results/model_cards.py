"""A table of the paper's 18 models: creator, release, size and host."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import Any

from eai.base.files import parse_toml
from eai.results.table import Row, Table, TextCell, collect_rows_in_table

_UNKNOWN = "unknown"


def make_model_table() -> Table:
    """Return a table of the paper's models, one row each, in the paper's order; footnotes name sources."""
    notes = tuple([f"Size: {text}." for text in _read_model_data()["sizes"].values()])
    return replace(_make_model_rows(), notes=notes)


@collect_rows_in_table("model_cards", ("model", "creator", "identifier", "release", "parameters", "host"))
def _make_model_rows() -> Iterator[Row]:
    """The paper's models.

    Creator, identifier, release and host are those of the paper's appendix.
    """
    sources = list(_read_model_data()["sizes"])
    for card in _read_model_data()["card"]:
        size = card.get("size")
        marks = () if size is None else (1 + sources.index(card["size_source"]),)
        yield (
            card["model"],
            card["creator"],
            card["identifier"],
            card["release"].isoformat(),
            TextCell(size or _UNKNOWN, notes=marks),
            card["host"],
        )


@cache
def _read_model_data() -> dict[str, Any]:
    file = resources.files("eai.results") / "paper" / "model_cards.toml"
    return parse_toml(file.read_text(encoding="utf-8"))
