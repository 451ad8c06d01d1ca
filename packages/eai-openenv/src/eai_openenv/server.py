"""The server: OpenEnv's routes over households, the reward, health and meters."""

from __future__ import annotations

from functools import partial
from importlib.metadata import version

from fastapi import FastAPI, Request, Response
from fastapi.responses import JSONResponse
from openenv.core.env_server import ConcurrencyConfig, HTTPEnvServer

from eai.agents.rules import TRAINING, GameRules
from eai.base.errors import EaiError
from eai_openenv.household import Act, Household, Seen, Standing
from eai_openenv.limits import Limits
from eai_openenv.meters import Meters
from eai_openenv.rewards import reward_route
from eai_openenv.tasks import Tasks

__version__ = version("eai-bench-openenv")
"""Of this package."""


def create_app(tasks: Tasks, rules: GameRules = TRAINING, limits: Limits | None = None) -> FastAPI:
    """The application, for any ASGI server.

    Args:
        tasks: what it plays and rewards.
        rules: how tasks are played, and what answers and episodes are paid for.
        limits: what clients may ask for.
    """
    limits, meters = limits or Limits(), Meters()
    app = FastAPI(title="Embodied Agent Interface", version=__version__, max_body_size=limits.body_bytes)
    server = HTTPEnvServer(
        partial(Household, tasks, rules, meters),
        Act,
        Seen,
        concurrency_config=ConcurrencyConfig(
            max_concurrent_envs=limits.sessions, session_timeout=limits.idle_seconds
        ),
        env_name="eai",
        state_cls=Standing,
    )
    server.register_routes(app)
    meters.watch_sessions(lambda: server.active_sessions)
    app.include_router(reward_route(tasks, rules.reward, limits, meters))

    @app.exception_handler(EaiError)
    async def refuse(request: Request, error: EaiError) -> Response:
        """What a client asked for that there is not."""
        return JSONResponse({"detail": str(error)}, status_code=422)

    @app.get("/metrics", tags=["Health"])
    async def read_meters() -> Response:
        """The meters, for Prometheus."""
        return Response(meters.text(), media_type="text/plain; version=0.0.4")

    return app
