"""Connections that do not stay open for requests that never become whole."""

from __future__ import annotations

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

REQUEST_SECONDS = 60.0
"""How long a request may take to arrive, from its first byte to its last."""


class PromptProtocol(H11Protocol):
    """HTTP as uvicorn speaks it, on connections that are closed where a request does not arrive in time.

    uvicorn itself closes those on which nothing comes after a reply.
    """

    seconds = REQUEST_SECONDS
    _due: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """A client is there: from now on its first request is awaited."""
        super().connection_made(transport)
        self._due = self.loop.call_later(self.seconds, transport.abort)

    def data_received(self, data: bytes) -> None:
        """A part of a request, or all of it."""
        super().data_received(data)
        awaited = self.conn.their_state in (h11.IDLE, h11.SEND_BODY)
        if awaited and self._due is None:
            self._due = self.loop.call_later(self.seconds, self.transport.abort)
        elif not awaited:
            self._leave()

    def connection_lost(self, exc: Exception | None) -> None:
        """Nothing more will come."""
        self._leave()
        super().connection_lost(exc)

    def _leave(self) -> None:
        if self._due is not None:
            self._due.cancel()
            self._due = None
