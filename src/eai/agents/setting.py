"""Define the setting of episodes: how an agent acts, how much it sees, and how many actions it may take."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic import Field, field_validator, model_validator
from typing_extensions import Self

from eai.abilities.experiment import MAX_BUDGET, MAX_SEED, MAX_STEPS, RULES_SEPARATOR
from eai.abilities.protocol import Ability
from eai.base.errors import InputError, did_you_mean
from eai.tasks.options import Options
from eai.tasks.prompts.prompt import PromptSet

ACTING = Ability("acting")

AGENT_SETTING_FIELD = "agent"
"""Field of a question's metadata that contains the setting of the agent, as JSON (`AgentSetting`)."""


REACT, TEXT, AUTO = "react", "text", "auto"
"""Names of harnesses (programs that let a model act), by the form of the model's actions.

`REACT`: tool calls in the agent ``react`` of Inspect. `TEXT`: lines of text. `AUTO`: tool calls, but lines of
text after the first reply without a tool call.
"""

HARNESSES = (REACT, TEXT, AUTO)


PICTURES = "pictures"
"""Name of the feedback in which only rendered pictures show the facts."""


class AgentSetting(Options):
    """How an agent acts, and how much it sees; the standard setting by default.

    Attributes:
        harness: How a model acts: react (it calls the tools act, look and done), text (one command in each
            message), auto (tools, or text after the first reply that calls none), or module:object, which
            makes an Inspect agent of the tools.
        view: The objects that it may see: scene (all), or task (objects of the task).
        observe: How much of them it sees: partial (from its place), or full.
        feedback: The text after each action: changes, facts, outcome, or pictures (the outcome, and rendered
            pictures that show the facts).
        prompts: The set of prompts of the first message. prompts.set chooses it, too.
        slip: The probability that a possible action does not work.
        slip_seed: The seed of the draws of slips.
        budget: The maximum number of actions: this number times the length of the shortest known plan, plus
            8, but at least as many as the commands that are known to win.
        steps: The maximum number of actions, independent of the plan.
        tokens: The maximum number of tokens of an episode, in all questions and replies.
        seconds: The maximum number of seconds of an episode on the clock.
        verifier: Offer also the verifier's tools about the task, which harness=text cannot call. Such runs
            are never ranked with others.
    """

    harness: str = REACT
    view: str = "scene"
    observe: str = "partial"
    feedback: str = "changes"
    prompts: PromptSet = "eai"
    slip: float = Field(default=0.0, ge=0, le=1)
    slip_seed: int = Field(default=0, ge=-MAX_SEED, le=MAX_SEED)
    budget: float = Field(default=2.0, ge=0, le=MAX_BUDGET)
    steps: int | None = Field(default=None, ge=1, le=MAX_STEPS)
    tokens: int | None = Field(default=None, ge=1, le=MAX_SEED)
    seconds: int | None = Field(default=None, ge=1, le=MAX_SEED)
    verifier: bool = False

    @field_validator("harness")
    @classmethod
    def _check_harness(cls, harness: str) -> str:
        if harness not in HARNESSES and not re.fullmatch(r"[\w.]+:\w+", harness):
            expected = ", ".join(HARNESSES)
            hint = did_you_mean(harness, HARNESSES)
            raise InputError(f"agent.harness: expected {expected} or module:object, found {harness!r}{hint}")
        return harness

    @model_validator(mode="after")
    def _check_harness_can_call_verifier(self) -> Self:
        if self.verifier and self.harness == TEXT:
            raise InputError(f"agent.verifier: harness={TEXT} cannot call tools; choose {REACT} or {AUTO}")
        return self

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, Any]) -> AgentSetting:
        """Return the agent setting in a question's metadata, or `STANDARD` if it states no setting."""
        stated = metadata.get(AGENT_SETTING_FIELD)
        return STANDARD if stated is None else cls.model_validate_json(stated)

    @property
    def label(self) -> str:
        """Text with all fields that differ from their defaults; may be empty.

        It leaves out ``harness``, and ``slip_seed`` if no action slips.
        """
        exclude = {"harness"} if self.slip else {"harness", "slip_seed"}
        return make_rules_label(self.model_dump(mode="json", exclude_defaults=True, exclude=exclude))


def make_rules_label(values: Mapping[str, Any]) -> str:
    """Return a text with rules, given as a mapping from their names to their values."""
    return RULES_SEPARATOR.join([f"{name}-{str(value).lower()}" for name, value in values.items()])


STANDARD = AgentSetting()
"""The standard setting, in which agents act if the user sets no option of the section ``agent``."""
