"""Estimated lengths of questions and answers in tokens, and the context length that a server states."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

from inspect_ai.model import Model

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import EaiError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import Suite
from eai.run.job import DecodingOptions, is_built_in_model
from eai.run.request_errors import MIN_SECONDS_BETWEEN_TRIES, REFUSED, is_connection_refused
from eai.studies.variation import ModelEndpoint
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import Source

_TOKEN = re.compile(r"[^\W\d_]{1,7}|\d|(?:[^\w\s]|_)+|\n\s*")
"""Pattern of one estimated token: up to seven letters, a digit, signs in a row, or a line break.

For prompts of the paper's suites, the estimate is 0.84 to 1.38 times the count of a tokenizer. On average it
is 0.96 times that of SmolLM2, 1.08 of DeepSeek, 1.02 of Claude 2 and 1.12 of GPT-4. The simpler estimate of
one token for four characters would be 0.50 to 1.02 times the count.
"""

MIN_ANSWER_TOKENS = 1024
"""Minimum of the token limit that a run sets by default for an answer. Users may set a lower limit."""

GOLD_LENGTHS = 4
"""Default token limit of an answer, as a multiple of the data set's longest answer."""

_REASONING_MODEL = re.compile(
    r"think|reason|magistral|qwq|qwen-?3|gpt-(?:5|oss)|\b(?:r1|o[1-9])\b", re.IGNORECASE
)
"""Pattern of names of models that reason before they answer. Replies show whether other models reason."""

_PROVIDERS_OF_SERVERS = ("openai-api", "ollama", "llama-cpp-python")
"""Providers in Inspect that call a server of the user."""

_PROBE_SECONDS = 3.0
"""Maximum seconds to wait for a server to state its context length."""


def estimate_tokens(text: str) -> int:
    """Return an estimate of the tokens of a text."""
    return sum(1 for _ in _TOKEN.finditer(text))


def estimate_prompt_tokens(prompt: Prompt) -> int:
    """Return an estimate of the tokens of a prompt, without its pictures."""
    return sum(map(estimate_tokens, [prompt.system or "", prompt.user, *chain.from_iterable(prompt.turns)]))


def estimate_longest_answer(suite: Suite) -> int:
    """Return an estimate of the tokens of a suite's longest gold answer, or 0 without gold answers."""
    return max(_estimate_gold_answer_tokens_of_suite(suite).values(), default=0)


def _estimate_gold_answer_tokens_of_suite(suite: Suite) -> Mapping[str, int]:
    """Return a mapping from tasks to the estimated tokens of their gold answers.

    Tasks without a plan in the data set are left out, because a search for plans takes long.
    """
    if suite.ability not in PAPER_ABILITIES:
        return {}
    return _estimate_gold_answer_tokens(suite.benchmark, suite.ability, suite.source)


@lru_cache(maxsize=16)
def _estimate_gold_answer_tokens(benchmark: Benchmark, ability: Ability, source: Source) -> Mapping[str, int]:
    book = open_gold_answers(benchmark, ability, source)
    tasks: Mapping[str, object] = benchmark.tasks_for(ability, source)
    known_ids = [task_id for task_id in book if getattr(tasks[task_id], "script", True)]
    return {task_id: estimate_tokens(book[task_id].text) for task_id in known_ids}


def choose_default_max_answer_tokens(model: str, suite: Suite, decoding: DecodingOptions) -> int | None:
    """Return the default of the maximum number of tokens of an answer, or None for no limit.

    There is no limit for built-in models, for models that reason, and in abilities whose answers are episodes
    of several turns. A limit of the user replaces the default.
    """
    reasons = decoding.reasoning_effort not in (None, "none") or decoding.reasoning_tokens is not None
    is_limited = decoding.max_tokens is not None or reasons or get_declaration(suite.ability).takes_turns
    if is_limited or is_built_in_model(model) or _REASONING_MODEL.search(model):
        return None
    return max(MIN_ANSWER_TOKENS, GOLD_LENGTHS * estimate_longest_answer(suite))


REMEDIES = (
    "by estimate, for question and answer. Shorter questions: --set short. "
    "Shorter answers: --max-tokens. Only the tasks that fit: --with requests.too_long=skip. "
    "All tasks: --with requests.too_long=ask"
)
"""End of a message on tasks that do not fit into the model's context: options that help."""


class _TasksThatExceedContext(NamedTuple):
    """Tasks of a suite (an ability in a benchmark) that do not fit into a model's context.

    Attributes:
        suite: the suite.
        asked: number of tasks to ask.
        needs: mapping from each task that does not fit to the tokens of its question and answer.
    """

    suite: Suite
    asked: int
    needs: Mapping[str, int]


def find_long_tasks(
    suite: Suite, prompts: Mapping[str, Prompt], max_tokens: int | None, context: int
) -> _TasksThatExceedContext:
    """Return the tasks whose question and answer need more tokens than a context has.

    The length of an answer is the user's maximum, or else the length of the task's gold answer.
    """
    answers = (
        _estimate_gold_answer_tokens_of_suite(suite)
        if max_tokens is None
        else dict.fromkeys(prompts, max_tokens)
    )
    needs = {
        task_id: estimate_prompt_tokens(prompt) + answers.get(task_id, 0)
        for task_id, prompt in prompts.items()
    }
    return _TasksThatExceedContext(
        suite, len(prompts), {task_id: need for task_id, need in needs.items() if need > context}
    )


def describe_long_tasks(context: int, suites: Sequence[_TasksThatExceedContext]) -> str:
    """Return a text with the numbers of tasks that do not fit into a context, and their estimated lengths."""
    parts = []
    for suite, asked, needs in suites:
        if needs:
            lengths = sorted({min(needs.values()), max(needs.values())})
            parts.append(
                f"{len(needs):,} of {asked:,} tasks of {suite.domain} {suite.ability.value} need more than "
                f"{context:,} tokens ({' to '.join([f'{length:,}' for length in lengths])})"
            )
    return ", ".join(parts)


def is_endpoint_on_server_of_user(endpoint: ModelEndpoint) -> bool:
    """Whether a model runs on a server with OpenAI's protocol, at an address that the user chose."""
    provider = endpoint.model.partition("/")[0]
    return provider in _PROVIDERS_OF_SERVERS or (
        provider in ("openai", "vllm", "sglang") and endpoint.base_url is not None
    )


def read_context_length(model: Model) -> int | None:
    """Return the length of a model's context in tokens, or None if the model's server does not state it."""
    with _make_openai_client(model) as client:
        lengths = _yield_context_lengths(client, str(client.base_url), _find_served_name(model))
        return next((length for length in lengths if isinstance(length, int) and length > 0), None)


def require_server_at_model_address(model: Model) -> None:
    """Raise an error if no server listens at a model's address at two tries.

    Raises:
        EaiError: the connection is refused.
    """
    with _make_openai_client(model) as client:
        for is_last_try in (False, True):
            error = _find_connection_error(client)
            if error is None or not is_connection_refused(error):
                return
            if is_last_try:
                hint = "start it, or correct its address; the same command resumes from here"
                raise EaiError(f"{model}: {REFUSED} at {client.base_url}: {hint}") from error
            time.sleep(MIN_SECONDS_BETWEEN_TRIES)


def _make_openai_client(model: Model) -> Any:
    """Return a client of a model's server, which speaks OpenAI's protocol."""
    from openai import OpenAI

    address, key = getattr(model.api, "base_url", None), model.api.api_key or "none"
    return OpenAI(base_url=address, api_key=key, max_retries=0, timeout=_PROBE_SECONDS)


def _find_connection_error(client: Any) -> Exception | None:
    from openai import APIConnectionError, OpenAIError

    try:
        client.get("/models", cast_to=object)
    except APIConnectionError as error:
        return error
    except (OpenAIError, ValueError):  # the server listens, but lists no models
        pass
    return None


def _find_served_name(model: Model) -> str:
    name = getattr(model.api, "service_model_name", None)
    return str(name() if name is not None else model.api.model_name)


def _yield_context_lengths(client: Any, address: str, model_name: str) -> Iterator[Any]:
    """Yield the context lengths that a server states for a model, the most reliable one first.

    vLLM and SGLang list ``max_model_len`` with each model, hosted services ``context_length``. llama.cpp
    lists ``meta.n_ctx``, older versions only in ``/props``. Ollama states the context of a running model in
    ``/api/ps``, and otherwise the parameter ``num_ctx``. The last values are the context lengths for which
    the model was trained. A value that the server does not state is None.

    Args:
        client: OpenAI's client of the server.
        address: address of the server.
        model_name: name of the model.
    """
    root = address.rstrip("/").removesuffix("/v1")
    models = _read_dicts_in_field(_request_json(client, "/models"), "data")
    entries = [entry for entry in models if entry.get("id") == model_name] or (
        models if len(models) == 1 else []
    )
    listed = entries[0] if entries else {}
    meta = _get_dict_or_empty(listed.get("meta"))
    yield from (listed.get("max_model_len"), meta.get("n_ctx"), listed.get("context_length"))
    properties = _get_dict_or_empty(_request_json(client, f"{root}/props"))
    yield _get_dict_or_empty(properties.get("default_generation_settings")).get("n_ctx")
    for running in _read_dicts_in_field(_request_json(client, f"{root}/api/ps"), "models"):
        if running.get("name") in (model_name, f"{model_name}:latest"):
            yield running.get("context_length")
    shown = _get_dict_or_empty(_request_json(client, f"{root}/api/show", {"model": model_name}))
    parameter = re.search(r"^num_ctx\s+(\d+)", str(shown.get("parameters")), re.MULTILINE)
    yield int(parameter[1]) if parameter else None
    training = _get_dict_or_empty(shown.get("model_info"))
    yield from [value for key, value in training.items() if key.endswith(".context_length")]
    yield meta.get("n_ctx_train")


def _request_json(client: Any, path: str, body: Mapping[str, str] | None = None) -> Any:
    """Return the JSON that a server sends for a path, or None if the server does not know the path.

    Args:
        client: OpenAI's client of the server.
        path: the path.
        body: the body of a POST request; None for a GET request.
    """
    from openai import OpenAIError

    try:
        if body is None:
            return client.get(path, cast_to=object)
        return client.post(path, body=body, cast_to=object)
    except (OpenAIError, ValueError):
        return None


def _get_dict_or_empty(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _read_dicts_in_field(value: Any, field: str) -> list[dict[str, Any]]:
    entries = _get_dict_or_empty(value).get(field)
    return [_get_dict_or_empty(entry) for entry in entries] if isinstance(entries, list) else []
