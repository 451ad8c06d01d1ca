"""Household tasks as a taskset of verifiers, played step by step."""

from __future__ import annotations

from eai_verifiers.harness import InProcessHarness
from eai_verifiers.steps import StepsEnv, StepsTaskset

__all__ = ["InProcessHarness", "StepsEnv", "StepsTaskset"]
