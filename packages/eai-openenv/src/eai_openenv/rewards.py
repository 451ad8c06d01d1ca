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

_ANSWERS_PER_TURN = 64
"""Number of answers that are scored before another request gets its turn."""


class RewardRequest(BaseModel):
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
    def _check_equal_lengths(self) -> RewardRequest:
        if not len(self.query) == len(self.prompts) == len(self.labels):
            raise ValueError("query, prompts and labels must have equal lengths")
        return self


class RewardReply(BaseModel):
    """The rewards of the answers, in order. ``scores`` repeats ``rewards``; ``extra_logs`` has the metrics.

    The reward is 0 if the task can pay no reward, or if the query does not contain the prompt.
    """

    rewards: list[float]
    scores: list[float]
    extra_logs: dict[str, list[float]]


def make_reward_router(tasks: Tasks, shaping: Shaping, limits: Limits, meters: Meters) -> APIRouter:
    """Return the route ``POST /reward``."""
    router, scorers = APIRouter(tags=["Reward"]), Scorers()

    @router.post("/reward")
    async def reward(batch: RewardRequest, request: Request) -> RewardReply:
        """Reward answers. Equal requests have equal replies, so a client repeats an interrupted request."""
        start_time = time.perf_counter()
        if len(batch.labels) > limits.answers:
            raise HTTPException(
                413, f"{len(batch.labels)} answers in a request: expected at most {limits.answers}"
            )
        labels = [tasks.require_served_task(label) for label in batch.labels]
        rewards: list[float] = []
        logs: dict[str, list[float]] = {metric: [] for metric in (*METRICS, PROMPT_NOT_FOUND)}
        seconds_left = limits.reward_seconds
        for start in range(0, len(labels), _ANSWERS_PER_TURN):  # requests take turns
            turn = slice(start, start + _ANSWERS_PER_TURN)
            request_part = (batch.query[turn], batch.prompts[turn], labels[turn], batch.shaping or shaping)
            try:
                result, seconds = await scorers.compute_rewards(*request_part, seconds_left)
            except (TimeoutError, BrokenWorkerProcess) as error:
                timeout = f"scoring takes longer than {limits.reward_seconds:g} s"
                reason = timeout if isinstance(error, TimeoutError) else "a scoring process has died"
                answer_range = f"answers {start + 1} to {start + len(request_part[0])}"
                raise HTTPException(503, f"{reason}: ended at {answer_range}") from error
            seconds_left -= seconds
            rewards += _make_list(result["rewards"])
            for metric, values in logs.items():
                values += _make_list(result["extra_logs"][metric])
            if await request.is_disconnected():
                break  # the client has left, so nobody needs the rest
        number_without_prompt = int(sum(logs[PROMPT_NOT_FOUND]))
        meters.count_rewards(len(rewards), time.perf_counter() - start_time, number_without_prompt)
        return RewardReply(rewards=rewards, scores=rewards, extra_logs=logs)

    return router


def _make_list(values: float | list[float]) -> list[float]:
    """Return a list of values; `reward_func` returns the value of a single answer without a list."""
    return values if isinstance(values, list) else [values]
