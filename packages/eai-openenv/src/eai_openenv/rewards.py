"""Rewards over HTTP for batches of answers in OpenRLHF's format."""

from __future__ import annotations

import time
from typing import Annotated

from anyio import BrokenWorkerProcess
from fastapi import APIRouter, HTTPException, Request
from pydantic import BaseModel, ConfigDict, Field, model_validator

from eai.agents.rewards import PROMPT_NOT_FOUND
from eai.results.reward import METRICS, Shaping
from eai_openenv.limits import Limits
from eai_openenv.meters import Meters
from eai_openenv.scorers import Scorers
from eai_openenv.tasks import Tasks

_TURN = 64
"""Number of answers that are scored before another request gets its turn."""


class Batch(BaseModel):
    """A request for the rewards of answers.

    Attributes:
        query: Prompts, each followed by its answer.
        prompts: The prompts alone. The answer is the rest of the query; all of it if the prompt is empty.
        labels: References of the tasks, as `Suite.reference` writes them.
        shaping: Shaping of the rewards; None for the server's.
    """

    model_config = ConfigDict(extra="forbid")

    query: list[str]
    prompts: list[str]
    labels: Annotated[list[str], Field(min_length=1)]
    shaping: Shaping | None = None

    @model_validator(mode="after")
    def _one_each(self) -> Batch:
        if not len(self.query) == len(self.prompts) == len(self.labels):
            raise ValueError("query, prompts and labels must have equal lengths")
        return self


class Rewards(BaseModel):
    """The rewards of the answers, in order. ``scores`` repeats ``rewards``; ``extra_logs`` has the metrics.

    The reward is 0 if the task can pay no reward, or if the query does not contain the prompt.
    """

    rewards: list[float]
    scores: list[float]
    extra_logs: dict[str, list[float]]


def reward_route(tasks: Tasks, shaping: Shaping, limits: Limits, meters: Meters) -> APIRouter:
    """Return the route ``POST /reward``."""
    router, scorers = APIRouter(tags=["Reward"]), Scorers()

    @router.post("/reward")
    async def reward(batch: Batch, request: Request) -> Rewards:
        """Reward answers. Equal requests have equal replies, so a client repeats an interrupted request."""
        begun = time.perf_counter()
        if len(batch.labels) > limits.answers:
            raise HTTPException(
                413, f"{len(batch.labels)} answers in a request: expected at most {limits.answers}"
            )
        labels = [tasks.known(label) for label in batch.labels]
        paid: list[float] = []
        logs: dict[str, list[float]] = {metric: [] for metric in (*METRICS, PROMPT_NOT_FOUND)}
        left = limits.reward_seconds
        for start in range(0, len(labels), _TURN):  # requests take turns
            turn = slice(start, start + _TURN)
            asked = (batch.query[turn], batch.prompts[turn], labels[turn], batch.shaping or shaping)
            try:
                of_turn, took = await scorers.pay(*asked, left)
            except (TimeoutError, BrokenWorkerProcess) as error:
                late = f"scoring takes longer than {limits.reward_seconds:g} s"
                told = late if isinstance(error, TimeoutError) else "a scoring process has died"
                place = f"answers {start + 1} to {start + len(asked[0])}"
                raise HTTPException(503, f"{told}: ended at {place}") from error
            left -= took
            paid += _each(of_turn["rewards"])
            for metric, values in logs.items():
                values += _each(of_turn["extra_logs"][metric])
            if await request.is_disconnected():
                break  # the client has left, so nobody needs the rest
        lost = int(sum(logs[PROMPT_NOT_FOUND]))
        meters.rewarded(len(paid), time.perf_counter() - begun, lost)
        return Rewards(rewards=paid, scores=paid, extra_logs=logs)

    return router


def _each(values: float | list[float]) -> list[float]:
    """Return a list of values; `reward_func` returns the value of a single answer without a list."""
    return values if isinstance(values, list) else [values]
