"""Let an agent of the OpenAI Agents SDK (`pip install openai-agents`) play over `eai serve mcp`."""

import asyncio
import json
from pathlib import Path

from agents import Agent, Runner, set_default_openai_api
from agents.mcp import MCPServerStreamableHttp

set_default_openai_api("chat_completions")


async def play(ticket):
    """Play the episode of a ticket."""
    world = {"url": "http://127.0.0.1:8000/mcp", "headers": {"Authorization": f"Bearer {ticket}"}}
    async with MCPServerStreamableHttp(world, client_session_timeout_seconds=60) as server:
        await Runner.run(Agent("agent", mcp_servers=[server]), "Look, and do your task.", max_turns=200)


for row in json.loads(Path("served/tickets.json").read_text()):
    asyncio.run(play(row["ticket"]))
