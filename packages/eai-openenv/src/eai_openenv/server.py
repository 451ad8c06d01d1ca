"""HTTP server with OpenEnv's routes for household tasks, the reward, health and meters."""

from __future__ import annotations

from functools import partial
from importlib.metadata import version

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from openenv.core.env_server import ConcurrencyConfig, HTTPEnvServer

from eai.agents.rules import TRAINING, GameRules
from eai.base.errors import EaiError
from eai_openenv.household import Household, HouseholdAction, HouseholdObservation, HouseholdState
from eai_openenv.limits import Limits
from eai_openenv.meters import Meters
from eai_openenv.rewards import make_reward_router
from eai_openenv.tasks import Tasks

__version__ = version("eai-bench-openenv")
"""Version of this package."""


def create_app(tasks: Tasks, rules: GameRules = TRAINING, limits: Limits | None = None) -> FastAPI:
    """Return the application for an ASGI server.

    Args:
        tasks: Tasks that it plays and rewards.
        rules: Rules of the game, and the reward of answers and episodes.
        limits: Limits on the requests of clients; None for the defaults.
    """
    limits, meters = limits or Limits(), Meters()
    app = FastAPI(title="Embodied Agent Interface", version=__version__, max_body_size=limits.body_bytes)
    server = HTTPEnvServer(
        partial(Household, tasks, rules, meters),
        HouseholdAction,
        HouseholdObservation,
        concurrency_config=ConcurrencyConfig(
            max_concurrent_envs=limits.sessions, session_timeout=limits.idle_seconds
        ),
        env_name="eai",
        state_cls=HouseholdState,
    )
    server.register_routes(app)
    meters.watch_sessions(lambda: server.active_sessions)
    app.include_router(make_reward_router(tasks, rules.reward, limits, meters))

    @app.exception_handler(EaiError)
    async def refuse(request: Request, error: EaiError) -> Response:
        """Reply to a request for something that does not exist with the error's message."""
        return JSONResponse({"detail": str(error)}, status_code=422)

    @app.exception_handler(RequestValidationError)
    async def refuse_malformed(request: Request, error: RequestValidationError) -> Response:
        """Reply to a malformed request with its errors, without its values: JSON has no NaN."""
        errors = [{key: item[key] for key in ("type", "loc", "msg")} for item in error.errors()]
        return JSONResponse({"detail": errors}, status_code=422)

    @app.get("/metrics", tags=["Health"])
    async def read_meters() -> Response:
        """Return the counters in the text format of Prometheus."""
        return Response(meters.format_counters(), media_type="text/plain; version=0.0.4")

    return app
