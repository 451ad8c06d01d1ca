"""The application that OpenEnv's tools start: ``uvicorn eai_openenv.app:app``.

It serves the benchmarks that the variable ``EAI_DOMAINS`` names, separated by commas; VirtualHome without it.
They are opened when the application is asked for, not when this module is imported.
"""

from __future__ import annotations

import os
from typing import Any

from eai_openenv.server import create_app
from eai_openenv.tasks import Tasks

DOMAINS = "EAI_DOMAINS"
"""The variable."""


def __getattr__(name: str) -> Any:
    if name != "app":
        raise AttributeError(name)
    return create_app(Tasks({domain: domain for domain in os.environ.get(DOMAINS, "virtualhome").split(",")}))
