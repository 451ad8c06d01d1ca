"""The paper's figures of its data set (Table 2, and those in its text), with what there is to say of them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@dataclass(frozen=True, slots=True)
class PrintedFigure:
    """A figure as printed.

    Attributes:
        remark: why another number comes out, or how this one does; empty if there is nothing to say.
    """

    value: int | float
    remark: str = ""


@cache
def paper_statistics(domain: str) -> Mapping[str, PrintedFigure]:
    """Label of a figure -> the paper's, for one of its domains; nothing for others."""
    file = resources.files("eai.results") / "paper" / "dataset_statistics.toml"
    found = tomllib.loads(file.read_text(encoding="utf-8")).get(domain, {})
    return {
        label: PrintedFigure(entry["printed"], entry.get("remark", ""))
        if isinstance(entry, dict)
        else PrintedFigure(entry)
        for label, entry in found.items()
    }
