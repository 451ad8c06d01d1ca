"""Jobs: what is to be asked of which model, and how."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, TypeAlias

from pydantic import Field

from eai.abilities.answer_schema import Schema
from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, SCENE_GRAPH, Ability
from eai.agents.setting import AGENT
from eai.base.errors import InputError, did_you_mean
from eai.base.json_value import Json
from eai.benchmarks.prompt_library import answer_form
from eai.benchmarks.suite import Suite
from eai.results.codec import sha256_of
from eai.results.trials import Conversation, Trials
from eai.studies.perception.scene_graph import SCENE
from eai.studies.variation import Endpoint
from eai.tasks.options import Options
from eai.tasks.prompts.prompt import Prompt

PROVIDER = "eai"
"""The provider of built-in models, before the slash of their names."""

ERRATA = "errata"
"""The field of a question's metadata that says whether the task's own answers are the corrected ones."""

CAPTIONER = "captioner"
"""The built-in model that lists what is in pictures."""

EXPLORERS = ("explorer", "greedy", "novel", "blind")
"""The built-in models that only act."""

MODELS = (
    *("oracle", "planner", "lookup", "copy", "empty", "random", "noisy", "replay", CAPTIONER),
    *EXPLORERS,
)
"""The built-in models."""

_ONLY: Mapping[str, Collection[Ability]] = {
    "planner": (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION),
    **dict.fromkeys(("lookup", "copy", "empty", "random"), (*PAPER_ABILITIES, Ability.ACTION_SEQUENCING)),
    CAPTIONER: (SCENE_GRAPH,),
    **dict.fromkeys(EXPLORERS, ()),
}
"""The abilities without turns that a built-in model answers, if it does not answer all."""


def can_answer(name: str, ability: Ability) -> bool:
    """Whether a model answers an ability. Other models than built-in ones answer all."""
    provider, _, model = name.partition("/")
    if provider != PROVIDER:
        return True
    if declaration_of(ability).takes_turns:
        return model != CAPTIONER
    return ability in _ONLY.get(model, (ability,))


def check_model(name: str) -> None:
    """Raise InputError for a built-in model that there is not, or a name that no provider can stand in."""
    known = [f"{PROVIDER}/{model}" for model in MODELS]
    provider, separator, _ = name.partition("/")
    if provider == PROVIDER and name not in known:
        raise InputError(f"{name}: expected one of {', '.join(known)}{did_you_mean(name, known)}")
    if not separator:
        hint = did_you_mean(f"{PROVIDER}/{name}", known)
        raise InputError(f"--model {name}: expected PROVIDER/NAME, such as openai/gpt-4o or {known[0]}{hint}")


_ReasoningEffort: TypeAlias = Literal["none", "minimal", "low", "medium", "high", "xhigh", "max"]
"""How much a model is to reason, in Inspect's words."""


class Decoding(Options):
    """How models answer.

    Attributes:
        temperature: For sampling.
        max_tokens: The most tokens of an answer.
        top_p: For sampling.
        seed: For sampling, where a provider takes one.
        reasoning_effort: none, minimal, low, medium, high, xhigh or max.
        reasoning_tokens: The most tokens of its reasoning.
        stop: Stop sequences as in the paper's runs.
        structured: Hold answers to the task's form and words, where a provider can.
    """

    temperature: float = Field(default=0.0, ge=0)
    max_tokens: int | None = Field(default=None, ge=1)
    top_p: float | None = Field(default=None, ge=0, le=1)
    seed: int | None = None
    reasoning_effort: _ReasoningEffort | None = None
    reasoning_tokens: int | None = Field(default=None, ge=1)
    stop: bool = True
    structured: bool = False

    @property
    def sampling(self) -> dict[str, int | float | str]:
        """The choices that only some providers know, of those that are made, by their names in Inspect."""
        chosen = {"top_p", "seed", "reasoning_effort", "reasoning_tokens"}
        return self.model_dump(mode="json", include=chosen, exclude_none=True)


class Pace(Options):
    """How requests are made, which changes no answer.

    Attributes:
        max_connections: Requests at a time; of a built-in model there is one.
        max_retries: How often a failed request is repeated.
        timeout: Seconds until a request has failed; the provider's if not given.
        batch: Use the provider's batch service, slower and cheaper.
    """

    max_connections: int | None = Field(default=None, ge=1)
    max_retries: int = Field(default=5, ge=0)
    timeout: int | None = Field(default=None, ge=1)
    batch: bool = False


@dataclass(frozen=True, slots=True)
class Job:
    """Tasks of a suite to be put to a model, each by its id, in the order of the data set.

    Attributes:
        suite: the suite.
        prompts: the questions by id, in order.
        epochs: how many answers to each.
        trials: how answers are carried out in an experiment; None where each question is asked once.
        about: what the built-in models are to know of questions besides, by task: fields of the metadata.
        experiment: what the log says of how the run differs from asking each question once; None for nothing.
    """

    endpoint: Endpoint
    suite: Suite
    prompts: Mapping[str, Prompt]
    epochs: int = 1
    decoding: Decoding = field(default_factory=Decoding)
    pace: Pace = field(default_factory=Pace)
    trials: Trials | None = None
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    experiment: Experiment | None = None

    @property
    def sha256(self) -> str:
        """Digest of all requests: two with the same one come to the same answers."""
        requests = [(name, self.request_sha256(name, prompt)) for name, prompt in self.prompts.items()]
        decisive: list[Json] = [self.epochs, requests]
        if self.trials is not None:
            decisive.append([self.trials.options.label, self.trials.suite.protocol.value])
        return sha256_of(json.dumps(decisive))

    def start_conversation(self, task_id: str, epoch: int) -> Conversation:
        """A task as it is put to the model."""
        if self.trials is None:
            return Conversation(partial(self.prompts.__getitem__, task_id))
        return self.trials.start_conversation(task_id, epoch)

    def answer_schema(self, task_id: str) -> Schema | None:
        """The form that answers are held to, with any objects where the scene is shown as it was perceived.

        None if answers may have any form.
        """
        if not self.decoding.structured:
            return None
        perceived = SCENE in self.metadata.get(task_id, {})
        task = None if perceived else self.suite.tasks.get(task_id)
        return answer_form(self.suite.benchmark, self.suite.ability, task, self.prompts[task_id])

    def request_sha256(self, task_id: str, prompt: Prompt, attempt: int = 1) -> str:
        """Digest of all that decides the answer to a prompt.

        The same question asked again is another request, or a run that resumes would take the first answer
        for all.
        """
        endpoint, decoding, form = self.endpoint, self.decoding, self.answer_schema(task_id)
        decisive = (
            (endpoint.model, sorted(endpoint.arguments.items()), endpoint.base_url),
            (decoding.temperature, decoding.max_tokens, decoding.stop, decoding.structured),
            (prompt.sha256, prompt.stop),
            *sorted(decoding.sampling.items()),
            *((attempt,) if attempt > 1 else ()),
            *((form,) if form is not None else ()),
            *((setting,) if (setting := self.metadata.get(task_id, {}).get(AGENT)) else ()),
        )
        return sha256_of(json.dumps(decisive))
