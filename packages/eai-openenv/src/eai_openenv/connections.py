"""HTTP connections that are closed if a request does not arrive completely in time."""

from __future__ import annotations

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

REQUEST_SECONDS = 60.0
"""Maximum seconds from the first byte of a request to its last."""


class TimeLimitedProtocol(H11Protocol):
    """uvicorn's HTTP protocol with a time limit for the arrival of each request.

    uvicorn itself closes connections on which nothing arrives after a reply.
    """

    seconds = REQUEST_SECONDS
    _time_limit: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start the time limit of a new client's first request."""
        super().connection_made(transport)
        self._time_limit = self.loop.call_later(self.seconds, transport.abort)

    def data_received(self, data: bytes) -> None:
        """Receive bytes of a request, and start or end its time limit."""
        super().data_received(data)
        awaited = self.conn.their_state in (h11.IDLE, h11.SEND_BODY)
        if awaited and self._time_limit is None:
            self._time_limit = self.loop.call_later(self.seconds, self.transport.abort)
        elif not awaited:
            self._cancel_time_limit()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the time limit of a closed connection."""
        self._cancel_time_limit()
        super().connection_lost(exc)

    def _cancel_time_limit(self) -> None:
        if self._time_limit is not None:
            self._time_limit.cancel()
            self._time_limit = None
