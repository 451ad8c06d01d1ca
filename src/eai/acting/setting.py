"""The setting of episodes: how an agent acts, what it sees, and how much it may do."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any

from eai.abilities.options import Options, option
from eai.abilities.protocol import Ability

ACTING = Ability("acting")

AGENT = "agent"
"""The field of a question's metadata that has the setting in which a task is played, as JSON."""


class Harness(str, Enum):
    """How a model acts: by calls of tools in Inspect's ``react``, or by lines of text."""

    REACT = "react"
    TEXT = "text"


class Setting(Options):
    """How an agent acts, and the world in which it does; by default the standard setting."""

    harness: Harness = option(
        "How a model acts: react (it calls the tools act, look and done), or text (a command a message).",
        Harness.REACT,
    )
    view: str = option("The objects that it may see: scene (all), or task (those that matter).", "scene")
    observe: str = option("How much of them it sees: partial (from where it is), or full.", "partial")
    feedback: str = option("What it is told of each action: changes, facts or outcome.", "changes")
    slip: float = option("The probability that a possible action does not work.", 0.0, ge=0, le=1)
    slip_seed: int = option("The seed of those draws.", 0)
    budget: float = option(
        "The most actions: so many times the shortest plan known and 8 more, or the reference's.", 2.0, ge=0
    )
    steps: int | None = option("The most actions whatever the plan.", ge=1)
    tokens: int | None = option("The most tokens of an episode, those of all questions and replies.", ge=1)
    seconds: int | None = option("The most seconds of an episode on the clock.", ge=1)

    @classmethod
    def of_question(cls, about: Mapping[str, Any]) -> Setting:
        """The setting that the metadata of a question has; the standard one if they have none."""
        stated = about.get(AGENT)
        return STANDARD if stated is None else cls.model_validate_json(stated)

    @property
    def label(self) -> str:
        """The choices but that of a harness that differ from the standard setting; empty where none does."""
        chosen = self.model_dump(mode="json", exclude_defaults=True, exclude={"harness"})
        return "-".join(f"{name}-{value}" for name, value in chosen.items())


STANDARD = Setting()
"""How tasks are played where nothing else is chosen."""
