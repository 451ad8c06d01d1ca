"""Find signs that a server or model ignored the requested form, a part of a prompt, or the tools.

A run prints them at its end.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from textwrap import shorten

from jsonschema import Draft202012Validator

from eai.abilities.answer_schema import Schema
from eai.abilities.declaration import get_declaration
from eai.agents.play import StoredEpisode, read_episode
from eai.agents.setting import AGENT_SETTING_FIELD, AUTO
from eai.results.trials import Answer, TaskIdAndEpoch
from eai.run.job import QuestionJob, is_built_in_model

_MAX_QUOTED = 60
"""Maximum number of characters of a quoted reply."""

_MIN_PROMPT_LENGTH = 2000
"""Minimum length of the prompts whose counted tokens are checked, in characters."""

_MIN_TOKENS = 256
"""Minimum token count of a long prompt. A server that reports a lower count has not counted tokens."""

_MAX_CHARACTERS_PER_TOKEN = 8
"""Number of characters that a token has at most, on average over a prompt."""


def describe_unfulfilled_requests(
    job: QuestionJob, answers: Mapping[TaskIdAndEpoch, Answer]
) -> tuple[str, ...]:
    """Return a sentence on each part of the requests that the server or the model seems to have ignored.

    Args:
        job: the questions, and the options of their requests.
        answers: mapping from task and epoch (round of answers) to the answer.
    """
    describers = (
        _describe_answers_of_wrong_form,
        _describe_prompts_cut_off_by_server,
        _describe_replies_without_tool_calls,
    )
    return tuple(filter(None, [describe(job, answers) for describe in describers]))


def _describe_answers_of_wrong_form(job: QuestionJob, answers: Mapping[TaskIdAndEpoch, Answer]) -> str:
    """Return a sentence on the answers that do not have the requested form; empty if all have it."""
    checked = misfits = 0
    for (task_id, _), answer in answers.items():
        schema = job.make_answer_schema(task_id)
        if schema is not None and not answer.is_cut_off:
            checked += 1
            misfits += not _matches_schema(answer.text, schema)
    if not misfits:
        return ""
    return (
        f"the server seems to ignore generation.structured: "
        f"{misfits} of {checked} answers do not have the requested form"
    )


def _matches_schema(text: str, schema: Schema) -> bool:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return False
    is_valid: bool = Draft202012Validator(schema).is_valid(value)
    return is_valid


def _describe_prompts_cut_off_by_server(job: QuestionJob, answers: Mapping[TaskIdAndEpoch, Answer]) -> str:
    """Return a sentence on prompts that the server seems to have cut off, or an empty text.

    The server has counted too few tokens for the length of such a prompt. Questions of attempts and episodes
    are left out, because they grow from turn to turn. Built-in models are left out, because they count words.
    """
    grows = job.trials is not None or get_declaration(job.suite.ability).takes_turns
    if grows or is_built_in_model(job.endpoint.model):
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


def _describe_replies_without_tool_calls(job: QuestionJob, answers: Mapping[TaskIdAndEpoch, Answer]) -> str:
    """Return a sentence on the episodes with a reply that called no tool, or an empty text."""
    if not get_declaration(job.suite.ability).takes_turns:
        return ""
    read = [read_episode(answer.text) for answer in answers.values()]
    episodes = [episode for episode in read if isinstance(episode, StoredEpisode) and episode.without_call]
    if not episodes:
        return ""
    idle = sum(not episode.turns for episode in episodes)
    quoted = shorten(episodes[0].without_call, _MAX_QUOTED, placeholder=" ...")
    count = f"in {len(episodes)} of {len(read)} episodes a reply called no tool ({quoted!r})"
    if episodes[0].harness == AUTO:
        return f"{count}; later commands are lines of text"
    advice = f"{AGENT_SETTING_FIELD}.harness=text or auto takes lines"
    return f"{count}, in {idle} of them before any action; {advice}"
