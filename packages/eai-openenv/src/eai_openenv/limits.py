"""Limits on the requests of a server's clients."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a server.

    Attributes:
        sessions: Maximum number of open sessions.
        idle_seconds: Seconds without a message after which a session is closed.
        message_bytes: Maximum length of a session's message; the ASGI server enforces it.
        body_bytes: Maximum length of an HTTP request.
        answers: Maximum number of answers of a request.
        reward_seconds: Maximum seconds of a request for rewards.
    """

    sessions: int = 64
    idle_seconds: float = 600.0
    message_bytes: int = 1 << 16
    body_bytes: int = 1 << 25
    answers: int = 1024
    reward_seconds: float = 60.0
