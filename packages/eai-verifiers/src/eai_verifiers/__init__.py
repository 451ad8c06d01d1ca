"""Household tasks as a taskset of verifiers: one prompt, one answer."""

from __future__ import annotations

from eai_verifiers.environment import HouseholdEnv
from eai_verifiers.harness import InProcessHarness
from eai_verifiers.taskset import HouseholdTaskset

__all__ = ["HouseholdEnv", "HouseholdTaskset", "InProcessHarness"]
