"""A job: the questions of a suite for one model, with the options of requests.

A suite is the tasks of one ability in a benchmark.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import partial
from typing import Literal, TypeAlias

from pydantic import Field

from eai.abilities.answer_schema import Schema
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, SCENE_GRAPH, Ability
from eai.agents.setting import AGENT_SETTING_FIELD
from eai.base.errors import InputError, did_you_mean
from eai.base.json_value import Json
from eai.benchmarks.prompt_library import make_answer_schema
from eai.benchmarks.suite import Suite
from eai.results.codec import hash_text
from eai.results.trials import Conversation, ReplanningConversationFactory
from eai.studies.perception.scene_graph import SCENE
from eai.studies.variation import ModelEndpoint
from eai.tasks.options import Options, remove_secrets
from eai.tasks.prompts.prompt import Prompt, make_memory_saving_prompt_mapping

PROVIDER = "eai"
"""Name of the provider of built-in models: the text before the slash of their names."""

ERRATA = "errata"
"""Field of a question's metadata: whether known errors (errata) in the data set's answer are corrected."""

KEPT_TASKS = 100
"""Maximum number of tasks, of scorers and of gold answers that a run keeps in memory."""

CAPTIONER = "captioner"
"""Built-in model that lists the objects in pictures."""

EXPLORERS = ("explorer", "greedy", "novel", "blind")
"""Built-in models that only play episodes. They have no answers to abilities without episodes."""

MODELS = (
    *("oracle", "planner", "lookup", "copy", "empty", "random", "noisy", "replay", CAPTIONER),
    *EXPLORERS,
)
"""Names of the built-in models."""

_USUAL_PROVIDERS = (
    *("anthropic", "azureai", "bedrock", "deepseek", "google", "groq", "hf", "mistral", "ollama", "openai"),
    *("openai-api", "openrouter", "sglang", "together", "vllm"),
)
"""Providers in Inspect that many people use. They are suggested if the user misspells a provider."""

_ABILITIES_OF_MODEL: Mapping[str, Collection[Ability]] = {
    "planner": (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION),
    **dict.fromkeys(("lookup", "copy", "empty", "random"), (*PAPER_ABILITIES, Ability.ACTION_SEQUENCING)),
    CAPTIONER: (SCENE_GRAPH,),
    **dict.fromkeys(EXPLORERS, ()),
}
"""Mapping from built-in models to the abilities that they can answer in one reply, without playing a game.

Models that answer all abilities are left out.
"""


def can_model_answer(name: str, ability: Ability) -> bool:
    """Whether a model can answer questions of an ability. All models can, except some built-in models."""
    provider, _, model = name.partition("/")
    if provider != PROVIDER:
        return True
    if get_declaration(ability).takes_turns:
        return model != CAPTIONER
    return ability in _ABILITIES_OF_MODEL.get(model, (ability,))


def is_built_in_model(name: str) -> bool:
    """Whether a model is built in, such as ``eai/oracle``."""
    return name.startswith(f"{PROVIDER}/")


def check_model_name(name: str) -> None:
    """Raise InputError for an unknown built-in model, or a name without a provider."""
    known_models = [f"{PROVIDER}/{model}" for model in MODELS]
    provider, separator, _ = name.partition("/")
    if provider == PROVIDER and name not in known_models:
        raise InputError(
            f"{name}: expected one of {', '.join(known_models)}{did_you_mean(name, known_models)}"
        )
    if not separator:
        similar = get_close_matches(name, MODELS, 1)
        hint = f"; did you mean {PROVIDER}/{similar[0]}?" if similar else ""
        raise InputError(
            f"--model {name}: expected PROVIDER/NAME, such as openai/gpt-4o or {known_models[0]}{hint}"
        )


def describe_unknown_provider(model: str) -> str:
    """Return one line on a model whose provider, the word before the first slash, is unknown to Inspect."""
    provider = model.partition("/")[0]
    hint = did_you_mean(provider, _USUAL_PROVIDERS) or "."
    return (
        f"Inspect has no provider {provider}{hint} For a server with OpenAI's protocol, "
        f"write openai-api/{model}."
    )


_ReasoningEffort: TypeAlias = Literal["none", "minimal", "low", "medium", "high", "xhigh", "max"]
"""Reasoning effort of a model, in Inspect's words."""


class DecodingOptions(Options):
    """Options of the models' answers.

    Attributes:
        temperature: Temperature of sampling.
        max_tokens: Maximum number of tokens of an answer; by default a multiple of the longest gold answer.
        top_p: Probability mass of nucleus sampling.
        seed: Seed of sampling, if the provider supports it.
        reasoning_effort: none, minimal, low, medium, high, xhigh or max.
        reasoning_tokens: Maximum number of tokens of the model's reasoning.
        stop: Use the stop sequences of the paper's runs.
        structured: Restrict answers to the task's schema and words, if the provider supports it.
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
    def provider_options(self) -> dict[str, int | float | str]:
        """The chosen options that only some providers support, by their names in Inspect."""
        chosen = {"top_p", "seed", "reasoning_effort", "reasoning_tokens"}
        return self.model_dump(mode="json", include=chosen, exclude_none=True)


class RequestOptions(Options):
    """Options of requests that change no answer.

    Attributes:
        max_connections: Maximum number of requests at a time; one for built-in models.
        max_retries: Maximum number of repetitions of a failed request. OpenAI's library sends each of them up
            to three times, unless -M max_retries=0.
        timeout: Seconds after which a request fails; the provider's default if not given.
        batch: Use the provider's batch service, slower and cheaper.
        too_long: Tasks that do not fit into the model's context: stop (ask nothing), skip (leave them out) or
            ask.
    """

    max_connections: int | None = Field(default=None, ge=1)
    max_retries: int = Field(default=5, ge=0)
    timeout: int | None = Field(default=None, ge=1)
    batch: bool = False
    too_long: Literal["stop", "skip", "ask"] = "stop"


@dataclass(frozen=True, slots=True)
class QuestionJob:
    """The questions of one suite (ability in a benchmark) to one model, in the order of the data set.

    Attributes:
        suite: the suite.
        prompts: mapping from task ids to questions, in order.
        epochs: number of answers to each question.
        trials: executes the answers and asks again after failures; None if each question is sent once.
        metadata: mapping from task ids to the metadata of questions, for the built-in models.
        experiment: the options of studies (variations of the questions, such as another form of scenes), for
            the log; None without options.
        answer_limit: default of the maximum number of tokens of an answer, which follows from the suite.
    """

    endpoint: ModelEndpoint
    suite: Suite
    prompts: Mapping[str, Prompt]
    epochs: int = 1
    decoding: DecodingOptions = field(default_factory=DecodingOptions)
    pace: RequestOptions = field(default_factory=RequestOptions)
    trials: ReplanningConversationFactory | None = None
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    experiment: Experiment | None = None
    answer_limit: int | None = None

    @property
    def sha256(self) -> str:
        """Digest of all requests. The answers in a log can be reused for every job with the same digest."""
        requests = [(name, self.hash_request(name, prompt)) for name, prompt in self.prompts.items()]
        decisive: list[Json] = [self.epochs, requests]
        if self.trials is not None:
            decisive.append([self.trials.options.label, self.trials.suite.protocol.value])
        return hash_text(json.dumps(decisive))

    def split_into_jobs(self, max_samples: int) -> Iterator[QuestionJob]:
        """Yield jobs with consecutive tasks of this job, in order.

        A sample is a task in one epoch (round of answers to all tasks). A job has at most ``max_samples``
        samples, or a single task with more samples.
        """
        task_ids, size = list(self.prompts), max(1, max_samples // self.epochs)
        if len(task_ids) <= size:
            yield self
            return
        for start in range(0, len(task_ids), size):
            prompts = make_memory_saving_prompt_mapping(
                (name, self.prompts[name]) for name in task_ids[start : start + size]
            )
            yield replace(self, prompts=prompts)

    def start_conversation(self, task_id: str, epoch: int) -> Conversation:
        """Return the conversation of a task in one epoch (round of answers): its questions in order."""
        if self.trials is None:
            return Conversation(partial(self.prompts.__getitem__, task_id))
        return self.trials.start_conversation(task_id, epoch)

    def make_answer_schema(self, task_id: str) -> Schema | None:
        """Return the JSON schema to which answers are restricted, or None without a restriction.

        If the question shows a perceived scene, answers may name any objects.
        """
        if not self.decoding.structured:
            return None
        perceived = SCENE in self.metadata.get(task_id, {})
        task = None if perceived else self.suite.tasks.get(task_id)
        return make_answer_schema(self.suite.benchmark, self.suite.ability, task, self.prompts[task_id])

    def hash_request(self, task_id: str, prompt: Prompt, attempt: int = 1) -> str:
        """Return the digest of everything on which the answer to a prompt depends. API keys are left out.

        A question that is repeated in a later attempt has another digest. Otherwise a resumed run would take
        the first answer for all attempts.
        """
        endpoint, decoding, schema = self.endpoint, self.decoding, self.make_answer_schema(task_id)
        decisive = (
            (endpoint.model, sorted(remove_secrets(endpoint.arguments).items()), endpoint.base_url),
            (decoding.temperature, decoding.max_tokens, decoding.stop, decoding.structured),
            (prompt.sha256, prompt.stop),
            *sorted(decoding.provider_options.items()),
            *((attempt,) if attempt > 1 else ()),
            *((schema,) if schema is not None else ()),
            *((setting,) if (setting := self.metadata.get(task_id, {}).get(AGENT_SETTING_FIELD)) else ()),
        )
        return hash_text(json.dumps(decisive))
