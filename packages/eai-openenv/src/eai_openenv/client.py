"""A typed client for episodes; OpenEnv's generic client does the same with dictionaries."""

from __future__ import annotations

from typing import Any

from openenv.core import EnvClient
from openenv.core.client_types import StepResult

from eai_openenv.household import HouseholdAction, HouseholdObservation, HouseholdState


class HouseholdClient(EnvClient[HouseholdAction, HouseholdObservation, HouseholdState]):
    """Plays the episodes of a server: ``HouseholdClient(base_url=...).sync()``."""

    def _step_payload(self, action: HouseholdAction) -> dict[str, Any]:
        return {"command": action.command}

    def _parse_result(self, payload: dict[str, Any]) -> StepResult[HouseholdObservation]:
        done, reward = bool(payload.get("done", False)), payload.get("reward")
        metadata = payload.get("metadata") or {}
        observation = HouseholdObservation(
            text=payload["observation"]["text"], done=done, reward=reward, metadata=metadata
        )
        return StepResult(observation=observation, reward=reward, done=done)

    def _parse_state(self, payload: dict[str, Any]) -> HouseholdState:
        state: HouseholdState = HouseholdState.model_validate(payload)
        return state
