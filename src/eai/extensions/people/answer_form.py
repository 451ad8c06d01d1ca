"""The form on which a person answers questions exactly as models get them: one page, without a server.

What is typed stays in the browser until the person saves it as a response file, which ``eai score`` reads
like any model's. Beside each answer the file says how many seconds its question was in sight, and the digest
of what was shown.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from eai.abilities.declaration import declaration_of
from eai.abilities.notation.goals import WrittenGoal
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.results.page import build_page, encode_for_script
from eai.results.responses import SUFFIX
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import USUAL, Source
from eai.tasks.task import GoalKind

SCRIPTS = ("dom.js", "tables.js", "form.js")
"""The parts of the program, in the order in which they need each other."""

PREDICATE, FIRST, SECOND = "\u0001predicate", "\u0001first", "\u0001second"
"""The placeholder in a pattern of an answer for the words that a person chooses."""


def form_html(
    benchmark: Benchmark, ability: Ability, prompts: Mapping[str, Prompt], source: Source = USUAL
) -> str:
    """The page.

    Args:
        benchmark: the benchmark.
        ability: what is asked for.
        prompts: the questions by id of their task, in the order in which they are shown.
        source: where the data set is.

    Raises:
        InputError: the ability takes turns, in which a page carries no actions out.
    """
    if declaration_of(ability).takes_turns:
        raise InputError(f"{ability}: a file carries no actions out; people act by eai play --page")
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
        "goals": goal_pattern(benchmark, source) if ability is Ability.GOAL_INTERPRETATION else None,
        "operators": _operators(benchmark, prompts, source)
        if ability is Ability.TRANSITION_MODELING
        else None,
    }
    return build_page("eai.extensions.people", "form", SCRIPTS, encode_for_script(content))


def goal_pattern(benchmark: Benchmark, source: Source) -> Json:
    """An answer with one goal of each kind, in which `PREDICATE`, `FIRST` and `SECOND` stand for words.

    Actions are in it only where tasks ask for any: not all benchmarks have a place for them.
    """
    patterns = [WrittenGoal(PREDICATE, (FIRST,)), WrittenGoal(PREDICATE, (FIRST, SECOND))]
    if any(task.goals_of(GoalKind.ACTION) for task in benchmark.tasks(source).values()):
        patterns.append(WrittenGoal(PREDICATE, is_action=True))
    notation = benchmark.notation.goals
    pattern: Json = json.loads(notation.join(notation.write(patterns)))
    return pattern


def _operators(benchmark: Benchmark, prompts: Mapping[str, Prompt], source: Source) -> Json:
    """Name and parameters of the operators that are asked for, by task; the question says as much."""
    tasks = benchmark.operators(source)
    return {
        task_id: [
            {"name": name, "parameters": tasks[task_id].domain.operators[name].parameters}
            for name in tasks[task_id].operators
        ]
        for task_id in prompts
    }
