"""Worker processes that score answers, so that a slow answer delays neither sessions nor other requests."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

from anyio import CapacityLimiter, fail_after, to_process

from eai.agents.rewards import reward_func
from eai.results.reward import Shaping


class Scorers:
    """A pool of worker processes: one for each processor, and at least two.

    Each scores one request at a time. A process that exceeds its time limit is killed and replaced.
    """

    def __init__(self) -> None:
        number = max(2, os.cpu_count() or 0)
        self._free_workers, self._worker_processes = CapacityLimiter(number), CapacityLimiter(number)

    async def compute_rewards(
        self,
        queries: Sequence[str],
        prompts: Sequence[str],
        labels: Sequence[str],
        shaping: Shaping,
        seconds: float,
    ) -> tuple[dict[str, Any], float]:
        """Return the result of `reward_func` for some answers, and the seconds that it took.

        Args:
            queries: Prompts, each followed by its answer.
            prompts: The prompts alone.
            labels: References of the tasks.
            shaping: Shaping of the rewards.
            seconds: Maximum seconds, counted from the moment when a process is free.

        Raises:
            TimeoutError: The scoring exceeds the maximum.
            BrokenWorkerProcess: The process ended by itself, or did not start.
            InputError: A task does not exist.
        """
        async with self._free_workers:
            start_time = time.perf_counter()
            compute = partial(reward_func, queries, prompts, labels, shaping=shaping)
            with fail_after(seconds):
                result = await to_process.run_sync(compute, cancellable=True, limiter=self._worker_processes)
            return result, time.perf_counter() - start_time
