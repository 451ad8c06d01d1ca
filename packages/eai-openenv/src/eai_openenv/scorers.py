"""Processes that score, so that an answer that takes long delays neither sessions nor other requests."""

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
    """As many processes as there are processors, and two at least; each is at one thing at a time.

    One that comes to no end is killed, and another takes its place.
    """

    def __init__(self) -> None:
        number = max(2, os.cpu_count() or 0)
        self._free, self._processes = CapacityLimiter(number), CapacityLimiter(number)

    async def pay(
        self,
        queries: Sequence[str],
        prompts: Sequence[str],
        labels: Sequence[str],
        shaping: Shaping,
        seconds: float,
    ) -> tuple[dict[str, Any], float]:
        """What `reward_func` says of some answers, and how many seconds that took.

        Args:
            queries: prompts with answers.
            prompts: the prompts.
            labels: the tasks.
            shaping: what answers are paid for.
            seconds: how long that may take, once a process is free for it.

        Raises:
            TimeoutError: it takes longer.
            BrokenWorkerProcess: the process came to an end of its own, or to no beginning.
            InputError: there is no such task.
        """
        async with self._free:
            begun = time.perf_counter()
            asked = partial(reward_func, queries, prompts, labels, shaping=shaping)
            with fail_after(seconds):
                told = await to_process.run_sync(asked, cancellable=True, limiter=self._processes)
            return told, time.perf_counter() - begun
