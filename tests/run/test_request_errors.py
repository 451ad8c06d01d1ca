from __future__ import annotations

import socket

import pytest
from inspect_ai._util.error import pip_dependency_error
from inspect_ai.model import get_model

from eai.run import request_errors
from eai.run.request_errors import (
    describe_error,
    get_message_without_markup,
    is_connection_refused,
    is_library_or_key_missing,
    is_prompt_too_long,
    limit_tries_of_refused_connections,
)

TOO_LONG = "the question is too long for the model's context"

REFUSALS = {
    "vllm": (
        "This model's maximum context length is 2048 tokens. However, you requested 2049 tokens (1681 in the "
        "messages, 368 in the completion). Please reduce the length of the messages or completion."
    ),
    "vllm, prompt alone": (
        "This model's maximum context length is 2048 tokens. However, your request has 4031 input tokens. "
        "Please reduce the length of the input messages."
    ),
    "vllm, max_tokens": (
        "'max_tokens' or 'max_completion_tokens' is too large: 1024. This model's maximum context length is "
        "2048 tokens and your request has 1500 input tokens (1024 > 2048 - 1500)."
    ),
    "vllm, input processor": (
        "The decoder prompt (length 4031) is longer than the maximum model length of 2048. Make sure that "
        "`max_model_len` is no smaller than the number of text tokens."
    ),
    "llama.cpp": (
        "{'error': {'code': 400, 'message': 'request (4031 tokens) exceeds the available context size (2048 "
        "tokens), try increasing it', 'type': 'exceed_context_size_error', 'n_prompt_tokens': 4031, "
        "'n_ctx': 2048}}"
    ),
    "openai": (
        "This model's maximum context length is 2048 tokens. However, your messages resulted in 6164 tokens. "
        "Please reduce the length of the messages."
    ),
    "anthropic": "prompt is too long: 213462 tokens > 2048 maximum",
}
"""Messages that name the context of 2,048 tokens, as servers send them."""

REFUSALS_WITHOUT_A_LENGTH = {
    "llama.cpp, older": "the request exceeds the available context size, try increasing it",
    "llama.cpp, while answering": "Context size has been exceeded.",
    "ollama": "prompt too long; exceeded max context length by 1024 tokens",
    "ollama, runner": "the input length exceeds the context length",
    "openai, responses": "Your input exceeds the context window of this model. Please adjust your input.",
    "openai, code": "{'error': {'message': '9 < 10', 'code': 'context_length_exceeded'}}",
}


@pytest.mark.parametrize("message", REFUSALS.values(), ids=REFUSALS)
def test_servers_that_refuse_a_long_question_are_reported_in_one_way(message: str) -> None:
    assert describe_error(RuntimeError(f"Error code: 400 - {message}")) == f"{TOO_LONG} of 2,048 tokens"


@pytest.mark.parametrize("message", REFUSALS_WITHOUT_A_LENGTH.values(), ids=REFUSALS_WITHOUT_A_LENGTH)
def test_a_refusal_that_names_no_length_is_reported_without_a_length(message: str) -> None:
    assert describe_error(RuntimeError(f"Error code: 400 - {message}")) == TOO_LONG


@pytest.mark.parametrize(
    "message",
    [
        "max_tokens is too large: 1000000. This model supports at most 16384 completion tokens",
        "Unsupported parameter: 'stop' is not supported with this model",
        "Rate limit reached for requests: 2048 tokens per minute",
    ],
)
def test_other_refusals_are_not_reported_as_long_questions(message: str) -> None:
    assert not is_prompt_too_long(RuntimeError(message))
    assert describe_error(RuntimeError(message)) == f"RuntimeError: {message}"


def make_refused_error(*, in_group: bool = False) -> Exception:
    """Return the error of a client whose connection was refused."""
    cause: BaseException = ConnectionRefusedError(111, "Connection refused")
    if in_group:
        group = OSError("All connection attempts failed")
        group.exceptions = (OSError("::1"), cause)  # type: ignore[attr-defined]
        cause = group
    error = RuntimeError("Connection error.")
    error.__cause__ = cause
    return error


def test_a_refused_connection_is_recognised_below_the_errors_of_clients() -> None:
    assert is_connection_refused(make_refused_error())
    assert is_connection_refused(make_refused_error(in_group=True))
    assert not is_connection_refused(TimeoutError())


def raise_from(cause: BaseException) -> Exception:
    """Return the vague error that a client raises from a cause."""
    error = ConnectionError("Connection error.")
    error.__cause__ = RuntimeError("no details")
    error.__cause__.__cause__ = cause
    return error


def test_a_vague_error_of_the_network_is_reported_with_its_cause() -> None:
    unknown_host = socket.gaierror(-2, "Name or service not known")
    assert describe_error(raise_from(unknown_host)) == (
        "ConnectionError: Connection error. (Name or service not known)"
    )


def test_a_cause_that_may_quote_a_key_is_not_reported() -> None:
    refusal = ValueError("Illegal header value b'Bearer sk-1'")
    assert describe_error(raise_from(refusal)) == "ConnectionError: Connection error."


def test_a_missing_library_of_a_provider_is_reported_with_its_remedy() -> None:
    error = pip_dependency_error("vLLM Server", ["vllm"])
    assert is_library_or_key_missing(error)
    assert describe_error(error) == (
        "ERROR: vLLM Server requires optional dependencies. Install with: pip install vllm"
    )
    assert not is_library_or_key_missing(RuntimeError("boom"))


@pytest.mark.parametrize(
    "message", ["the template ends in [/INST]", "run pip install vllm[audio]", "a [bold] b"]
)
def test_brackets_in_the_message_of_another_error_stay(message: str) -> None:
    assert get_message_without_markup(ValueError(f"{message}\n")) == message


def test_a_refused_connection_is_tried_twice_and_then_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = 100.0
    monkeypatch.setattr(request_errors.time, "monotonic", lambda: seconds)
    model = get_model("mockllm/model", memoize=False)
    model.api.should_retry = lambda error: True  # type: ignore[method-assign]
    limit_tries_of_refused_connections(limit_tries_of_refused_connections(model))
    decide = model.api.should_retry
    assert decide(make_refused_error())
    assert decide(make_refused_error()), "another request at the same time may try again"
    seconds += 3
    assert not decide(make_refused_error())
    assert decide(RuntimeError("another error"))
    seconds += 120
    assert decide(make_refused_error()), "a refusal long after the last one is a first try"
