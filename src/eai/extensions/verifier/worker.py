"""Answers queries that come as lines of JSON on standard input. `tools` starts this module as a process."""

from __future__ import annotations

import json
import os
from pathlib import Path

from eai.abilities.scorer import describe_exception
from eai.base.errors import EaiError
from eai.base.json_value import Json
from eai.extensions.verifier.queries import answer_query

MAX_RESULT = 1_000_000
"""Maximum length of the result of a query, in characters of JSON."""


def answer_queries_from_standard_input() -> None:
    """Write a line of JSON for each line of standard input, with the member ``result`` or ``error``."""
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    results = os.fdopen(os.dup(1), "w", encoding="utf-8")
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), 0)  # otherwise a query that names /dev/stdin would read the requests
    os.dup2(2, 1)  # libraries may print
    for line in requests:
        print(_make_reply_to_line(line), file=results, flush=True)


def _make_reply_to_line(line: str) -> str:
    request = json.loads(line)
    reply: dict[str, Json]
    try:
        reply = {"result": answer_query(request["name"], request["arguments"])}
    except MemoryError:  # no reply: the process has to end, because its memory is full
        raise
    except EaiError as error:
        reply = {"error": str(error)}
    except Exception as error:
        reply = {"error": describe_exception(error)}
    text = json.dumps(reply)
    if len(text) > MAX_RESULT:
        return json.dumps({"error": f"the result has more than {MAX_RESULT:,} characters"})
    return text


if __name__ == "__main__":
    answer_queries_from_standard_input()
