"""The form of the answer to a question, with the words that stand there, for providers that enforce one."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TypeAlias

from eai.abilities.answer_schema import Schema, closed, fits, text
from eai.abilities.protocol import Ability
from eai.abilities.subgoal_decomposition.notation import SubgoalNotation
from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.prompts.prompt import Prompt

_Form: TypeAlias = Callable[[Sequence[str] | None], Schema | None]
"""The form of an answer in which objects go by these words, or by any."""


def answer_form(benchmark: Benchmark, ability: Ability, task: Task | None, prompt: Prompt) -> Schema | None:
    """The form of the answer to a question; None if it is not known.

    Objects go by the words that the question lists. They may have any name where it does not list them all,
    as the form is not to tell what the question does not, and where providers do not take as many words.

    Args:
        benchmark: the benchmark.
        ability: what is asked for.
        task: whose objects the question lists; None if it tells of others.
        prompt: the question.
    """
    words, form = _words_and_form(benchmark, ability, task)
    schema = form(words) if words and _all_stand_in(f"{prompt.system or ''}\n{prompt.user}", words) else None
    return schema if schema is not None and fits(schema) else form(None)


def _all_stand_in(question: str, words: Sequence[str]) -> bool:
    return all(re.search(rf"(?<!\w){re.escape(word)}(?!\w)", question) for word in words)


def _words_and_form(benchmark: Benchmark, ability: Ability, task: Task | None) -> tuple[Sequence[str], _Form]:
    """What the objects of a task are called in answers, and the form of these."""
    domain = benchmark.domain
    match ability:
        case Ability.ACTION_SEQUENCING:
            plans = benchmark.plans
            return () if task is None else plans.words(task), lambda words: plans.schema(domain, words)
        case Ability.GOAL_INTERPRETATION:
            goals = benchmark.goals
            names = () if task is None else goals.names(task)
            relevant = () if task is None else task.relevant
            return list(dict.fromkeys([names[i] for i in relevant])), lambda w: goals.schema(domain, w)
        case Ability.SUBGOAL_DECOMPOSITION:
            subgoals = benchmark.subgoals or SubgoalNotation(domain)
            return (), lambda words: subgoals.schema()
        case Ability.TRANSITION_MODELING:
            return (), lambda words: closed({"output": text()})
