"""A typed client for episodes; OpenEnv's generic client does the same with dictionaries."""

from __future__ import annotations

from typing import Any

from openenv.core import EnvClient
from openenv.core.client_types import StepResult

from eai_openenv.household import Act, Seen, Standing


class HouseholdClient(EnvClient[Act, Seen, Standing]):
    """Plays the episodes of a server: ``HouseholdClient(base_url=...).sync()``."""

    def _step_payload(self, action: Act) -> dict[str, Any]:
        return {"command": action.command}

    def _parse_result(self, payload: dict[str, Any]) -> StepResult[Seen]:
        done, reward = bool(payload.get("done", False)), payload.get("reward")
        about = payload.get("metadata") or {}
        seen = Seen(text=payload["observation"]["text"], done=done, reward=reward, metadata=about)
        return StepResult(observation=seen, reward=reward, done=done)

    def _parse_state(self, payload: dict[str, Any]) -> Standing:
        standing: Standing = Standing.model_validate(payload)
        return standing
