"""Counters of a server, in the format of Prometheus."""

from __future__ import annotations

from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

_SECONDS = (0.0005, 0.001, 0.005, 0.01, 0.05, 0.1, 0.5, 1, 5, 10, 60)


class Meters:
    """The counters of one server. Several servers in a process have separate counters."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._episodes = Counter("eai_episodes", "Episodes that were begun.", registry=self._registry)
        self._ended = Counter("eai_episodes_ended", "Episodes that ended.", ["won"], registry=self._registry)
        self._turns = Counter(
            "eai_turns", "Turns, by the fault of the action.", ["fault"], registry=self._registry
        )
        self._answers = Counter("eai_answers", "Answers that were rewarded.", registry=self._registry)
        self._lost = Counter(
            "eai_prompts_not_found", "Answers whose query had no such prompt.", registry=self._registry
        )
        self._seconds = Histogram(
            "eai_reward_seconds",
            "From a request for rewards to its reply.",
            buckets=_SECONDS,
            registry=self._registry,
        )

    def watch_sessions(self, number: Callable[[], float]) -> None:
        """Report the number of sessions, which is read whenever the counters are read."""
        Gauge("eai_sessions", "Sessions that are open.", registry=self._registry).set_function(number)

    def count_episode_start(self) -> None:
        """Count a new episode."""
        self._episodes.inc()

    def count_turn(self, fault: str | None) -> None:
        """Count a turn, by the fault of its action."""
        self._turns.labels(fault or "none").inc()

    def count_episode_end(self, *, won: bool) -> None:
        """Count an ended episode."""
        self._ended.labels(str(won).lower()).inc()

    def count_rewards(self, answers: int, seconds: float, number_without_prompt: int) -> None:
        """Count rewarded answers, and queries without their prompt."""
        self._answers.inc(answers)
        self._lost.inc(number_without_prompt)
        self._seconds.observe(seconds)

    def format_counters(self) -> bytes:
        """Return all counters in the text format of Prometheus."""
        return generate_latest(self._registry)
