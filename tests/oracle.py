"""The reference package's verdicts on real model answers, read from beside the repository if they exist."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

_SHARED = Path(__file__).resolve().parents[2] / "shared"

NO_REFERENCE = "answers of models and the reference's verdicts on them are not published with this repository"
"""Reason of a test that is skipped because a file beside the repository is missing."""

DETAIL = ": it takes "
"""Separator in a reason: the summary of a run shows the text before it; the name of one file follows it."""

MODELS = (
    "claude-3-5-sonnet-20240620",
    "claude-3-opus-20240229",
    "cohere-command-r",
    "gemini-1.5-pro-preview-0409",
    "gpt-3.5-turbo-0125",
    "gpt-4o-2024-05-13",
    "llama-3-8b-chat",
    "mixtral-8x22b-instruct-v0.1",
    "o1-mini-2024-09-12",
)
"""Nine models of the paper whose public responses have verdicts."""

PIPELINE_MODELS = (
    "claude-3-opus-20240229",
    "cohere-command-r",
    "gemini-1.5-pro-preview-0409",
    "gpt-3.5-turbo-0125",
    "gpt-4o-2024-05-13",
    "llama-3-8b-chat",
    "mixtral-8x22b-instruct-v0.1",
)
"""Models of the paper's pipelines whose answers and prompts exist."""

SUBGOAL_CATEGORIES = {
    "Correct": "correct",
    "Runtime": "runtime",
    "GoalUnreachable": "goal_unreachable",
    "Hallucination": "hallucination",
    "NotParseable": "not_parseable",
}
"""Our categories of answers with subgoals, by the reference package's names."""

Oracle = Callable[[str, str, str], Any]
"""A function from domain, ability and name to the content of `<domain>/<ability>/<name>.json.gz`."""


def read_oracle(domain: str, ability: str, name: str) -> Any:
    """Return a file of verdicts, or skip the test without it."""
    return read_shared("oracle", domain, ability, f"{name}.json.gz")


def read_shared(*place: str) -> Any:
    """Return the content of a JSON file, packed or not, or skip the test without it."""
    path = _SHARED.joinpath(*place)
    if not path.is_file():
        pytest.skip(f"{NO_REFERENCE}{DETAIL}{path.relative_to(_SHARED.parent)}")
    content = path.read_bytes()
    return json.loads(gzip.decompress(content) if path.suffix == ".gz" else content)
