"""Make the page on which a person answers the questions that models get. The page needs no server.

Answers stay in the browser until the person saves a response file, which ``eai score`` reads like a model's.
For each answer the file also contains the seconds for which its question was visible, and the digest of the
question.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from eai.abilities.declaration import get_declaration
from eai.abilities.notation.goals import WrittenGoal
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.results.page import build_page, encode_for_script
from eai.results.responses import SUFFIX
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import USUAL_SOURCE, Source
from eai.tasks.task import GoalKind

SCRIPTS = ("dom.js", "tables.js", "form.js")
"""Names of the JavaScript files of the page, each after the files that it uses."""

PREDICATE, FIRST, SECOND = "\u0001predicate", "\u0001first", "\u0001second"
"""Placeholders for words that a person chooses, in the template of an answer to goal interpretation."""


def build_answer_form(
    benchmark: Benchmark, ability: Ability, prompts: Mapping[str, Prompt], source: Source = USUAL_SOURCE
) -> str:
    """Return the HTML of the page with questions.

    Args:
        benchmark: Benchmark of the tasks.
        ability: Ability that the questions test.
        prompts: Prompts by task id, in the order of the page.
        source: Access to the data set.

    Raises:
        InputError: Answers take several turns, between which only a page with a server can execute actions.
    """
    if get_declaration(ability).takes_turns:
        raise InputError(f"{ability}: a page without a server cannot execute actions; use eai play --page")
    questions: list[Json] = [
        {"task": task_id, "system": prompt.system, "user": prompt.user, "sha256": prompt.sha256}
        for task_id, prompt in prompts.items()
    ]
    content: Json = {
        "domain": benchmark.name,
        "title": benchmark.title,
        "ability": ability.value,
        "suffix": SUFFIX,
        "questions": questions,
        "goals": make_goal_answer_template(benchmark, source)
        if ability is Ability.GOAL_INTERPRETATION
        else None,
        "operators": _map_tasks_to_asked_operators(benchmark, prompts, source)
        if ability is Ability.TRANSITION_MODELING
        else None,
    }
    return build_page("eai.extensions.people", "form", SCRIPTS, encode_for_script(content))


def make_goal_answer_template(benchmark: Benchmark, source: Source) -> Json:
    """Return a template of an answer with one goal of each kind, as a JSON value.

    `PREDICATE`, `FIRST` and `SECOND` stand where the page inserts words that the person chooses. The template
    has an action goal only if a task of the benchmark has one, because not all notations can write action
    goals.
    """
    patterns = [WrittenGoal(PREDICATE, (FIRST,)), WrittenGoal(PREDICATE, (FIRST, SECOND))]
    if any(task.get_goals_of_kind(GoalKind.ACTION) for task in benchmark.tasks(source).values()):
        patterns.append(WrittenGoal(PREDICATE, is_action=True))
    notation = benchmark.notation.goals
    pattern: Json = json.loads(notation.join(notation.write(patterns)))
    return pattern


def _map_tasks_to_asked_operators(
    benchmark: Benchmark, prompts: Mapping[str, Prompt], source: Source
) -> Json:
    """Return for each task the names and parameters of the operators that its question asks for, as JSON."""
    tasks = benchmark.operator_tasks(source)
    return {
        task_id: [
            {"name": name, "parameters": tasks[task_id].domain.operators[name].parameters}
            for name in tasks[task_id].operators
        ]
        for task_id in prompts
    }
