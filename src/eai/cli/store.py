"""Which data set a command uses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.data.store import Store

DataFolder = Annotated[
    Path | None,
    typer.Option(
        "--data",
        help="Where the data set is; EAI_DATA_DIR or the user's cache if not given.",
    ),
]


def store(folder: Path | None) -> Store:
    """The store in a folder, or in the default one."""
    return Store() if folder is None else Store(folder)
