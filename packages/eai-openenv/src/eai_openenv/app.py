"""ASGI application that OpenEnv's tools start: ``uvicorn eai_openenv.app:app``.

It serves the benchmarks in the environment variable ``EAI_DOMAINS``, separated by commas, or VirtualHome if
the variable is not set. The first access to `app` opens the benchmarks, not the import of this module.
"""

from __future__ import annotations

import os
from typing import Any

from eai_openenv.server import create_app
from eai_openenv.tasks import Tasks

DOMAINS = "EAI_DOMAINS"
"""Environment variable with the benchmarks to serve."""


def __getattr__(name: str) -> Any:
    if name != "app":
        raise AttributeError(name)
    return create_app(Tasks({domain: domain for domain in os.environ.get(DOMAINS, "virtualhome").split(",")}))
