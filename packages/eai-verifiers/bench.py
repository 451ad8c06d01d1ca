"""Measure the processor time of a rollout in this process, with a fake model in another process.

python bench.py [--domain virtualhome] [--rollouts 200]
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import time
from multiprocessing.connection import Connection

from example import Model, Server, evaluate


def serve(port: Connection) -> None:
    """Serve the fake model, and send its port."""
    server = Server(("127.0.0.1", 0), Model)
    port.send(server.server_port)
    server.serve_forever()


def main() -> None:
    """Measure the same rollouts twice, because the first time fills the caches."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--domain", default="virtualhome")
    parser.add_argument("--rollouts", type=int, default=200)
    options = parser.parse_args()
    receiver, sender = multiprocessing.get_context("spawn").Pipe()
    model = multiprocessing.get_context("spawn").Process(target=serve, args=(sender,), daemon=True)
    model.start()
    address = f"http://127.0.0.1:{receiver.recv()}/v1"
    for turns, name in ((1, "eai-verifiers"), (10, "eai-verifiers-steps")):
        taskset = {"id": name, "domain": options.domain}
        if turns > 1:
            taskset |= {"task": {"rules": {"max_steps": turns}}}
        for _ in range(2):
            wall_start, cpu_start = time.perf_counter(), time.process_time()
            episodes = asyncio.run(evaluate(taskset, address, options.rollouts))
            wall_seconds = time.perf_counter() - wall_start
            cpu_seconds = time.process_time() - cpu_start
        failed = sum(not episode.traces or not episode.traces[0].ok for episode in episodes)
        times = f"{cpu_seconds / len(episodes) * 1e3:.1f} CPU ms, {wall_seconds / len(episodes) * 1e3:.0f} ms"
        print(f"{name}: {times} a rollout of {turns} turns; {len(episodes)} rollouts, {failed} failed")
    model.terminate()


if __name__ == "__main__":
    main()
