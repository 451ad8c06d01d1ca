"""The verifiers environment of whole answers: one agent, asked once, in this process."""

from __future__ import annotations

import verifiers.v1 as vf


class HouseholdEnvConfig(vf.SingleAgentEnvConfig):
    """Configuration of the agent. It needs no sandbox, because no reply is executed."""

    agent: vf.AgentConfig = vf.AgentConfig(runtime=vf.SubprocessConfig())


class HouseholdEnv(vf.SingleAgentEnv, vf.Env[HouseholdEnvConfig]):
    """Environment in which one agent answers a task once."""
