"""Find signs that a server ignored a part of the requests, for the closing lines of a run."""

from __future__ import annotations

import json
from collections.abc import Mapping

from jsonschema import Draft202012Validator

from eai.abilities.answer_schema import Schema
from eai.abilities.declaration import get_declaration
from eai.results.trials import Answer, AnswerKey
from eai.run.job import QuestionJob

_MIN_PROMPT_LENGTH = 2000
"""Minimum number of characters of a prompt whose tokens are compared with its length."""

_MIN_TOKENS = 256
"""Minimum number of counted tokens of a long prompt. A server that states a smaller number does not count."""

_MAX_CHARACTERS_PER_TOKEN = 8
"""Number of characters that a token has at most, on average over a prompt."""


def list_remarks(job: QuestionJob, answers: Mapping[AnswerKey, Answer]) -> tuple[str, ...]:
    """Return a sentence on each part of the requests that the server seems to have ignored.

    Args:
        job: the questions, and the options of their requests.
        answers: mapping from task and epoch to the answer.
    """
    return tuple(filter(None, (_describe_misfits(job, answers), _describe_cut_prompts(job, answers))))


def _describe_misfits(job: QuestionJob, answers: Mapping[AnswerKey, Answer]) -> str:
    """Return a sentence on the answers that do not have the requested form; empty if all have it."""
    checked = misfits = 0
    for (task_id, _), answer in answers.items():
        schema = job.make_answer_schema(task_id)
        if schema is not None and not answer.truncated:
            checked += 1
            misfits += not _has_form(answer.text, schema)
    if not misfits:
        return ""
    return (
        f"the server seems to ignore generation.structured: "
        f"{misfits} of {checked} answers do not have the requested form"
    )


def _has_form(text: str, schema: Schema) -> bool:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return False
    is_valid: bool = Draft202012Validator(schema).is_valid(value)
    return is_valid


def _describe_cut_prompts(job: QuestionJob, answers: Mapping[AnswerKey, Answer]) -> str:
    """Return a sentence on prompts with too few counted tokens; empty if all counts are credible.

    Questions of attempts and episodes are left out, because they grow from turn to turn.
    """
    if job.trials is not None or get_declaration(job.suite.ability).takes_turns:
        return ""
    counted = [
        (answer.usage.input_tokens, len(job.prompts[task_id].user) + len(job.prompts[task_id].system or ""))
        for (task_id, _), answer in answers.items()
        if answer.usage.input_tokens is not None and task_id in job.prompts
    ]
    short = [
        (tokens, length)
        for tokens, length in counted
        if length >= _MIN_PROMPT_LENGTH and _MIN_TOKENS <= tokens < length / _MAX_CHARACTERS_PER_TOKEN
    ]
    if not short:
        return ""
    tokens, length = max(short)
    return (
        f"the server seems to cut off prompts: it counted {tokens:,} tokens in a prompt of {length:,} "
        f"characters ({len(short)} of {len(counted)} prompts). Give it a longer context"
    )
