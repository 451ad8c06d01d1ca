"""Household tasks as an OpenEnv server: episodes over WebSockets, rewards over HTTP."""

from __future__ import annotations

from eai_openenv.connections import PromptProtocol
from eai_openenv.household import Act, Household, Seen
from eai_openenv.limits import Limits
from eai_openenv.server import create_app
from eai_openenv.tasks import Tasks

__all__ = ["Act", "Household", "Limits", "PromptProtocol", "Seen", "Tasks", "create_app"]
