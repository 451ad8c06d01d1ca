"""Errors of requests to models: their meaning in one line, and whether repetition can help."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

from inspect_ai.model import Model
from rich.text import Text
from tenacity import RetryError

UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, AssertionError)
"""Exceptions that providers' libraries raise if a reply has an unexpected form."""

FINAL_STATUSES = (401, 404)
"""HTTP statuses of failures that repetition cannot cure, such as a wrong key or an unknown model."""

REFUSED = "the server refuses the connection"
"""Failure of a request to an address at which no server listens."""

MIN_SECONDS_BETWEEN_TRIES = 1.0
"""Minimum seconds between a refused connection and the second, last try."""

_MAX_SECONDS_BETWEEN_TRIES = 60.0
"""Maximum seconds between a refused connection and the second, last try.

A refusal after more seconds counts as a first refusal again.
"""

_TOO_LONG = re.compile(
    r"context_length_exceeded|exceed_context_size|context size has been exceeded"
    r"|exceeds? the (?:available )?context|exceeded max(?:imum)? context length"
    r"|maximum (?:context|model) length|(?:prompt|input|question) is too long",
    re.IGNORECASE,
)
"""Pattern of messages with which vLLM, llama.cpp, Ollama, OpenAI and others refuse a long question."""

_CONTEXT_LENGTH = re.compile(
    r"""(?:maximum\ context\ length\ is|maximum\ model\ length\ of|available\ context\ size\ \(
    |['"]n_ctx['"]:|tokens\ >)\s*(\d[\d,]*)""",
    re.IGNORECASE | re.VERBOSE,
)
"""Pattern of messages that refuse a long question. Its group is the context length in tokens."""


_MAX_TOKENS = re.compile(r"max\w*tokens", re.IGNORECASE)
"""Pattern of messages about the maximum number of tokens of an answer, such as ``max_completion_tokens``."""


def describe_error(error: BaseException) -> str:
    """Return one line on why a request failed. If the request was repeated, the last error counts."""
    if is_connection_refused(error):
        return REFUSED
    if is_prompt_too_long(error):
        length = find_context_length(error)
        return f"the question is too long for the model's context{f' of {length:,} tokens' if length else ''}"
    error = _find_error_of_last_try(error)
    if is_library_or_key_missing(error):
        return get_message_without_markup(error)
    if type(error).__name__ == "AttemptTimeoutError":
        return f"no reply within {re.sub('[^0-9]', '', str(error))} s (requests.timeout)"
    lines = str(error).strip().splitlines()
    first_line = f"{type(error).__name__}: {lines[0].strip()}" if lines else type(error).__name__
    if isinstance(error, UNREADABLE):
        return f"the provider's reply cannot be read ({first_line if lines else 'it is no completion'})"
    cause = _find_first_cause(error)
    # the messages of other causes than OSError may contain an API key
    if cause is not error and isinstance(cause, OSError) and cause.strerror:
        return f"{first_line} ({cause.strerror})"
    return first_line


def _find_error_of_last_try(error: BaseException) -> BaseException:
    """Return the provider's error; if the request was repeated, the error of the last repetition."""
    if isinstance(error, RetryError | RuntimeError) and error.__cause__ is not None:
        return error.__cause__
    return error


def _find_first_cause(error: BaseException) -> BaseException:
    """Return the first error in the chain of an error's causes, because later errors say less."""
    while error.__cause__ is not None:
        error = error.__cause__
    return error


def is_library_or_key_missing(error: BaseException) -> bool:
    """Whether Inspect needs a library or a key that is missing, so that every request fails."""
    return type(_find_error_of_last_try(error)).__name__ == "PrerequisiteError"


def get_message_without_markup(error: BaseException) -> str:
    """Return the message of an error in one line, without the markup of Inspect's messages."""
    message = str(getattr(error, "message", error))
    if is_library_or_key_missing(error):  # only messages on missing prerequisites contain markup
        message = Text.from_markup(message).plain
    return " ".join(message.split())


def find_http_status(error: BaseException) -> int | None:
    """Return the HTTP status with which a request failed, or None if the status is unknown."""
    status = getattr(_find_error_of_last_try(error), "status_code", None)
    return status if isinstance(status, int) else None


def is_prompt_too_long(error: BaseException) -> bool:
    """Whether a server refused a request because the question does not fit into the model's context."""
    return _TOO_LONG.search(str(_find_error_of_last_try(error))) is not None


def is_refusal_of_max_tokens(error: BaseException) -> bool:
    """Whether a server refused the maximum number of tokens of an answer."""
    return _MAX_TOKENS.search(str(_find_error_of_last_try(error))) is not None


def find_context_length(error: BaseException) -> int | None:
    """Return the length of a model's context in tokens as an error message states it; None if it does not."""
    match = _CONTEXT_LENGTH.search(str(_find_error_of_last_try(error)))
    return int(match[1].replace(",", "")) if match else None


def is_connection_refused(error: BaseException) -> bool:
    """Whether an error comes from an address at which no server listens."""
    return any(isinstance(cause, ConnectionRefusedError) for cause in _yield_causes(error))


def _yield_causes(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and all errors that led to it, also those in a group.

    Clients that try several addresses raise a group of errors.
    """
    yield error
    for cause in (error.__cause__ or error.__context__, *getattr(error, "exceptions", ())):
        if cause is not None:
            yield from _yield_causes(cause)


def limit_tries_of_refused_connections(model: Model) -> Model:
    """Make a model's client try a refused connection only twice; return the model."""
    api = model.api
    if getattr(api.should_retry, "limits_refused_tries", False):
        return model
    should_retry, first_refusal = api.should_retry, float("-inf")

    def should_retry_unless_connection_refused_twice(error: Exception) -> object:
        nonlocal first_refusal
        seconds = time.monotonic() - first_refusal
        if is_connection_refused(error):
            if MIN_SECONDS_BETWEEN_TRIES <= seconds <= _MAX_SECONDS_BETWEEN_TRIES:
                return False
            if seconds > _MAX_SECONDS_BETWEEN_TRIES:
                first_refusal = time.monotonic()
        return should_retry(error)

    should_retry_unless_connection_refused_twice.limits_refused_tries = True  # type: ignore[attr-defined]
    api.should_retry = should_retry_unless_connection_refused_twice  # type: ignore[assignment, method-assign]
    return model
