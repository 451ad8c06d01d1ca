"""Household tasks as an OpenEnv server: episodes over WebSockets, rewards over HTTP."""

from __future__ import annotations

from eai_openenv.connections import TimeLimitedProtocol
from eai_openenv.household import Household, HouseholdAction, HouseholdObservation
from eai_openenv.limits import Limits
from eai_openenv.server import create_app
from eai_openenv.tasks import Tasks

__all__ = [
    "Household",
    "HouseholdAction",
    "HouseholdObservation",
    "Limits",
    "Tasks",
    "TimeLimitedProtocol",
    "create_app",
]
