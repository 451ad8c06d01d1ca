"""The reward over HTTP: batches as OpenRLHF sends them."""

from __future__ import annotations

import asyncio
import time
from typing import Annotated

from fastapi import APIRouter, HTTPException, Request
from pydantic import BaseModel, ConfigDict, Field, model_validator

from eai.envs.rewards import PROMPT_NOT_FOUND, reward_func
from eai.scoring.reward import METRICS
from eai.scoring.shaping import Shaping
from eai_openenv.limits import Limits
from eai_openenv.meters import Meters
from eai_openenv.tasks import Tasks


class Batch(BaseModel):
    """Answers to be rewarded.

    Attributes:
        query: prompts with answers.
        prompts: the prompts; an answer is what follows its prompt in the query, all of it if that is empty.
        labels: the tasks, as `Suite.reference` writes them.
        shaping: what answers are paid for, if not what the server pays for.
    """

    model_config = ConfigDict(extra="forbid")

    query: list[str]
    prompts: list[str]
    labels: Annotated[list[str], Field(min_length=1)]
    shaping: Shaping | None = None

    @model_validator(mode="after")
    def _one_each(self) -> Batch:
        if not len(self.query) == len(self.prompts) == len(self.labels):
            raise ValueError("expected as many query as prompts as labels")
        return self


class Rewards(BaseModel):
    """What the answers are worth, in order: ``scores`` repeats ``rewards``, ``extra_logs`` has the metrics.

    A task in which nothing can be earned pays 0, as does an answer whose query does not have its prompt.
    """

    rewards: list[float]
    scores: list[float]
    extra_logs: dict[str, list[float]]


def reward_route(tasks: Tasks, shaping: Shaping, limits: Limits, meters: Meters) -> APIRouter:
    """The route ``POST /reward``."""
    router = APIRouter(tags=["Reward"])

    @router.post("/reward")
    async def reward(batch: Batch, request: Request) -> Rewards:
        """Reward answers. Equal requests have equal replies: one that was cut off is simply sent again."""
        begun = time.perf_counter()
        if len(batch.labels) > limits.answers:
            raise HTTPException(413, f"expected at most {limits.answers} answers")
        paid: list[float] = []
        logs: dict[str, list[float]] = {metric: [] for metric in (*METRICS, PROMPT_NOT_FOUND)}
        for query, prompt, label in zip(batch.query, batch.prompts, batch.labels, strict=True):
            one = reward_func([query], [prompt], [tasks.known(label)], shaping=batch.shaping or shaping)
            paid.append(one["rewards"])
            for metric, values in logs.items():
                values.append(one["extra_logs"][metric])
            await asyncio.sleep(0)  # the turn of others
            if time.perf_counter() - begun > limits.reward_seconds:
                raise HTTPException(503, f"took longer than {limits.reward_seconds:g} s: send fewer answers")
            if len(paid) % 64 == 0 and await request.is_disconnected():
                break  # nobody waits for the rest
        lost = int(sum(logs[PROMPT_NOT_FOUND]))
        meters.rewarded(len(paid), time.perf_counter() - begun, lost)
        return Rewards(rewards=paid, scores=paid, extra_logs=logs)

    return router
