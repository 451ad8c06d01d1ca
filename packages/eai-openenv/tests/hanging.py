"""A scorer that hangs if an answer asks for it, in a module that worker processes can import."""

from __future__ import annotations

import os
import threading
from typing import Any

from eai.agents import rewards


def reward_func(queries: list[str], *others: Any, **options: Any) -> dict[str, Any]:
    if any("hang" in query for query in queries):
        threading.Event().wait()
    if any("die" in query for query in queries):
        os._exit(1)
    return rewards.reward_func(queries, *others, **options)
