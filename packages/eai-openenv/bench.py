"""Measure latencies of the server on this machine: steps of one client, and rewards of many clients.

    python bench.py [--domain virtualhome] [--clients 64] [--requests 2000]

The server is a separate process. All clients share one other process, whose own time is part of the latencies
that they measure. On a busy machine compare the server's processor time, which is printed, too.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import statistics
import subprocess
import sys
import time
from contextlib import AsyncExitStack
from pathlib import Path

import httpx
from openenv import GenericEnvClient

from eai.abilities.protocol import Ability
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.reward import open_reward_suite

PORT = 8765


def read_cpu_seconds(pid: int) -> float:
    """Return the processor seconds that a process has used (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def format_quantiles(seconds: list[float]) -> str:
    """Return the median and the 99th percentile in ms as text."""
    cuts = statistics.quantiles(seconds, n=100)
    return f"p50 {cuts[49] * 1e3:.2f} ms, p99 {cuts[98] * 1e3:.2f} ms of {len(seconds)}"


def measure_step_times(address: str, domain: str, number: int) -> list[float]:
    """Return the seconds of consecutive steps: first possible actions, then unreadable texts."""
    times: list[float] = []
    with GenericEnvClient(base_url=address).sync() as client:
        while len(times) < number:
            client.reset(split=domain, index=len(times) // 20 % 20)
            for turn in range(20):
                start_time = time.perf_counter()
                client.step({"command": f"WALK(bed.{turn})"})
                times.append(time.perf_counter() - start_time)
    return times


async def measure_reward_times(
    address: str, batches: list[dict[str, list[str]]], clients: int
) -> list[float]:
    """Return the seconds of requests with one answer each, from many clients at once."""
    times: list[float] = []
    waiting = iter(batches)

    async def ask(client: httpx.AsyncClient) -> None:
        for batch in waiting:
            start_time = time.perf_counter()
            (await client.post("/reward", json=batch)).raise_for_status()
            times.append(time.perf_counter() - start_time)

    async with AsyncExitStack() as stack:
        opened = [
            await stack.enter_async_context(httpx.AsyncClient(base_url=address, timeout=60))
            for _ in range(clients)
        ]
        for client in opened:  # making a client blocks this process for some 20 ms
            await client.get("/health")
        await asyncio.gather(*map(ask, opened))
    return times


def make_gold_batches(domain: str, number: int) -> list[dict[str, list[str]]]:
    """Return requests with one gold plan each, after a prompt of typical length."""
    suite = open_reward_suite(domain, Ability.ACTION_SEQUENCING)
    gold_answers, prompt = open_gold_answers(suite.benchmark, suite.ability), "x" * 14_000
    batches = []
    for batch_number in range(number):
        task_id = suite.task_ids[batch_number % len(suite.task_ids)]
        query = f"{prompt}{gold_answers[task_id].text}"
        batches.append({"query": [query], "prompts": [prompt], "labels": [suite.reference(task_id)]})
    return batches


def main() -> None:
    """Start a server, measure steps and rewards, print the latencies, and stop the server."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--domain", default="virtualhome")
    parser.add_argument("--clients", type=int, default=64)
    parser.add_argument("--requests", type=int, default=2000)
    options = parser.parse_args()
    address = f"http://127.0.0.1:{PORT}"
    command = [sys.executable, "-m", "eai_openenv", "--domain", options.domain, "--port", str(PORT)]
    with subprocess.Popen(command) as server:
        try:
            while True:
                try:
                    httpx.get(f"{address}/health")
                    break
                except httpx.ConnectError:
                    time.sleep(0.1)
            measure_step_times(address, options.domain, 400)  # makes the tasks beforehand
            used = read_cpu_seconds(server.pid)
            latencies = format_quantiles(measure_step_times(address, options.domain, options.requests))
            used = (read_cpu_seconds(server.pid) - used) / options.requests
            print(f"a step: {latencies}, {used * 1e3:.2f} CPU ms of the server")
            batches = make_gold_batches(options.domain, options.requests)
            asyncio.run(measure_reward_times(address, batches, options.clients))
            for clients in (1, options.clients):
                used, start_time = read_cpu_seconds(server.pid), time.perf_counter()
                latencies = format_quantiles(asyncio.run(measure_reward_times(address, batches, clients)))
                rate = len(batches) / (time.perf_counter() - start_time)
                used = (read_cpu_seconds(server.pid) - used) / len(batches)
                print(
                    f"a reward, {clients} clients: {latencies}, {rate:,.0f} a second, "
                    f"{used * 1e3:.2f} CPU ms of the server"
                )
        finally:
            server.terminate()


if __name__ == "__main__":
    main()
