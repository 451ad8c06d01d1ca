"""What a client may ask for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a server.

    Attributes:
        sessions: how many may be open at once.
        idle_seconds: after how long without a message a session is closed.
        message_bytes: the longest message of a session; it is the ASGI server that heeds it.
        body_bytes: the longest request over HTTP.
        answers: how many answers one request may bring.
        reward_seconds: how long one request for rewards may take.
    """

    sessions: int = 64
    idle_seconds: float = 600.0
    message_bytes: int = 1 << 16
    body_bytes: int = 1 << 25
    answers: int = 1024
    reward_seconds: float = 60.0
