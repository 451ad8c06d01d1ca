"""The environment of whole answers: one agent, asked once, in this process."""

from __future__ import annotations

import verifiers.v1 as vf


class HouseholdEnvConfig(vf.SingleAgentEnvConfig):
    """The one agent; nothing that it says is executed, so that it needs no sandbox."""

    agent: vf.AgentConfig = vf.AgentConfig(runtime=vf.SubprocessConfig())


class HouseholdEnv(vf.SingleAgentEnv, vf.Env[HouseholdEnvConfig]):
    """One agent plays a task by one answer."""
