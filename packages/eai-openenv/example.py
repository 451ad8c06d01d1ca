"""Play lamps over OpenEnv with a policy that needs no model, then request the reward of a whole answer.

    pip install ../.. .
    PYTHONPATH=../../examples/lamps python example.py

It starts its own server on a free port of this machine and stops it at the end.
"""

from __future__ import annotations

import json
import threading
import time

import httpx
import uvicorn
from openenv import GenericEnvClient

from eai_openenv import Tasks, create_app

SPLIT = "lamps:lamps"
POLICY = {
    "light": ("GO(lamp_1)", "PRESS(lamp_1)", "GO(lamp_2)", "PRESS(lamp_2)"),
    "pack": ("GO(ball)", "TAKE(ball)", "GO(box)", "OPEN(box)"),  # this action fails: the hand is full
}


def play(address: str) -> None:
    """Play one episode of each task."""
    with GenericEnvClient(base_url=address).sync() as client:
        for task_id, commands in POLICY.items():
            result = client.reset(task=f"{SPLIT}/action_sequencing/{task_id}")
            print(f"{task_id}: {len(result.observation['text'])} characters to read")
            for command in commands:
                result = client.step({"command": command})
                print(f"  {command:15} {result.observation['text'].splitlines()[0]}")
            print(f"  over: {result.done}, reward: {result.reward}")


def reward(address: str) -> None:
    """Request the reward of a whole plan in the way of OpenRLHF."""
    plan = json.dumps([{"action": "GO", "object": "ball"}, {"action": "PUT", "object": ["ball", "box"]}])
    prompt = "Put the ball into the box.\n"
    batch = {"query": [prompt + plan], "prompts": [prompt], "labels": [f"{SPLIT}/action_sequencing/pack"]}
    answer = httpx.post(f"{address}/reward", json=batch, timeout=60).raise_for_status().json()
    print(answer["rewards"], {name: values[0] for name, values in answer["extra_logs"].items() if values[0]})


def main() -> None:
    """Start the server, play, request a reward, and stop the server."""
    config = uvicorn.Config(create_app(Tasks({SPLIT: SPLIT})), port=0, log_level="warning")
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    address = f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    try:
        play(address)
        reward(address)
    finally:
        server.should_exit = True
        thread.join()


if __name__ == "__main__":
    main()
