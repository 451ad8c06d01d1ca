"""Find the plug-in that reads logs of other projects. `eai score` and `eai explain` pass such logs to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from eai.base.entry_points import get_entry_points, load_from_extension

_OFFER = "logs"


def find_plugin_that_reads_log(path: Path) -> Any:
    """Return the plug-in that can read a log (or a folder of logs) of another project, or None."""
    if not path.exists() or _OFFER not in get_entry_points("eai.offers"):
        return None
    extension = load_from_extension(_OFFER, str(path))
    return extension if extension.is_log(path) else None
