"""Queries about plans for the tasks of a benchmark. Each query is a function of its arguments alone.

The queries call the library's scorers, planner and worlds. Their results are JSON objects. The first line
of each docstring describes a tool to models.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any

import eai
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT
from eai.abilities.reports import report_steps
from eai.abilities.scorer import PlanScorer
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.base.entry_points import get_entry_points
from eai.base.errors import InputError, did_you_mean
from eai.base.json_value import Json
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_answers_of_planner
from eai.benchmarks.packs import is_stored
from eai.benchmarks.registry import OPENERS, is_path_of_task_files, list_benchmarks
from eai.benchmarks.suite import Suite
from eai.results.codec import dataclass_to_json, verdict_to_record_fields
from eai.tasks.task_files import open_task_files
from eai.world.action import Action
from eai.world.episode import Episode


def check_plan(benchmark: str, task: str, plan: str) -> Mapping[str, Json]:
    """Judge whether a plan can be executed and reaches all goals.

    The result has the fields that a verdict has in ``records.jsonl``, such as ``success``.
    """
    return verdict_to_record_fields(_open_suite(benchmark).score(task, plan))


def explain_plan(benchmark: str, task: str, plan: str) -> Mapping[str, Json]:
    """Judge a plan, and report on each step and goal. A failed plan is repaired."""
    verdict, explain, analyze_failure = _open_suite(benchmark).assess(task, plan)
    if analyze_failure is not None and verdict.excluded is None and not verdict.success:
        verdict = replace(verdict, repair=analyze_failure(DEFAULT_EFFORT).repair)
    return {**verdict_to_record_fields(verdict), "explanation": dataclass_to_json(explain())}


def find_plan(benchmark: str, task: str) -> Mapping[str, Json]:
    """Search for a plan that reaches all goals of a task.

    The result is a plan of the built-in search with the scorer's verdict, or the reason for finding no plan.
    """
    suite = _open_suite(benchmark)
    suite.scorer(task)  # raises InputError for an unknown task
    answer = open_answers_of_planner(suite.benchmark, suite.ability, suite.source)[task]
    if answer.why_none:
        return {"plan": None, "why_none": answer.why_none}
    return {"plan": answer.text, **verdict_to_record_fields(suite.score(task, answer.text))}


def predict_effects(benchmark: str, task: str, action: str, after: str = "") -> Mapping[str, Json]:
    """Say which facts an action would change, or why it is impossible.

    Args:
        benchmark: the reference to the benchmark.
        task: the id of the task, whose initial state is the start.
        action: a plan of one action.
        after: a plan of the actions before it; empty for none.

    Raises:
        InputError: a plan cannot be read, or an action before the last action is impossible.
    """
    scorer = _open_suite(benchmark).scorer(task)
    if not isinstance(scorer, PlanScorer):
        raise InputError(
            f"benchmark: {benchmark} has no plans that can be executed; choose a benchmark with plans"
        )
    earlier = _read_actions(scorer, after, "after") if after.strip() else ()
    actions = _read_actions(scorer, action, "action")
    if len(actions) != 1:
        raise InputError(f"action: expected a plan of one action, found {len(actions)} actions")
    episode = Episode(scorer.domain, scorer.task.initial)
    failure = episode.run(earlier)
    if failure is not None:
        report = report_steps(scorer.task, scorer.domain, episode.trajectory)[-1]
        number = len(episode.trajectory.steps)
        raise InputError(
            f"after: expected a plan that can be executed, but step {number}, {report.action}, "
            f"is impossible: {report.reason}"
        )
    episode.act(actions[0])
    return dataclass_to_json(report_steps(scorer.task, scorer.domain, episode.trajectory)[-1])


def _read_actions(scorer: PlanScorer, text: str, argument: str) -> tuple[Action, ...]:
    plan = scorer.read(text)
    if isinstance(plan, Unreadable):
        raise InputError(f"{argument}: expected a plan: {plan.reason}")
    actions = scorer.resolve_names(plan)
    if isinstance(actions, ErrorReport):
        raise InputError(f"{argument}: expected actions of the task: {actions.detail}")
    return actions


def _open_suite(reference: str) -> Suite:
    _refuse_reference_to_python_object(reference)
    if reference in list_benchmarks() and not is_stored(DataPackStore(), reference):
        raise InputError(f"benchmark: the data of {reference} are missing; run eai data fetch")
    return eai.open(reference, Ability.ACTION_SEQUENCING)


def _refuse_reference_to_python_object(benchmark_reference: str) -> None:
    """Raise InputError if a benchmark's reference names a Python object, because its module would run."""
    *prefixes, name = benchmark_reference.split(":")
    unknown = [prefix for prefix in prefixes if prefix not in get_entry_points(OPENERS)]
    if unknown:
        expected = "expected a benchmark's name, task files, or pddl:DOMAIN.pddl,PROBLEMS"
        raise InputError(
            f"benchmark: {benchmark_reference!r}: {expected}; "
            "Python objects are refused, such as MODULE:NAME, because importing their module runs code"
        )
    if is_path_of_task_files(name) and prefixes[-1:] not in (["pddl"], ["alfworld"]):
        _refuse_reference_to_python_object(open_task_files(Path(name)).base)


QUERIES: Mapping[str, Callable[..., Mapping[str, Json]]] = {
    "check_plan": check_plan,
    "explain_plan": explain_plan,
    "plan": find_plan,
    "predict": predict_effects,
}
"""Mapping from the name of a tool to the function that answers its queries."""

_PARAMETERS = {
    "benchmark": "A benchmark's name such as virtualhome, a path of task files, or "
    "pddl:DOMAIN.pddl,PROBLEM.pddl.",
    "task": "Id of the task. The id of a PDDL problem is its name.",
    "plan": 'The plan in the benchmark\'s notation, such as (pick-up a) or {"WALK": ["soap", "1002"]}.',
    "action": "A plan of one action, in the benchmark's notation.",
    "after": "A plan of the actions before; the task's initial state if left out.",
}


def describe_tool(name: str) -> tuple[str, Mapping[str, Any]]:
    """Return the description of a tool, and the JSON schema of its arguments. All arguments are texts."""
    parameters = signature(QUERIES[name]).parameters.values()
    texts = {each.name: {"type": "string", "description": _PARAMETERS[each.name]} for each in parameters}
    required = [each.name for each in parameters if each.default is each.empty]
    schema = {"type": "object", "properties": texts, "required": required, "additionalProperties": False}
    return (QUERIES[name].__doc__ or "").partition("\n")[0], schema


def answer_query(name: str, arguments: Mapping[str, object]) -> Mapping[str, Json]:
    """Return the result of a query.

    Raises:
        InputError: there is no such query, task or benchmark, or an argument is missing or wrong.
        DataError: the data set of the benchmark cannot be obtained.
    """
    check_arguments(name, arguments)
    return QUERIES[name](**arguments)


def check_arguments(name: str, arguments: Mapping[str, object]) -> None:
    """Raise InputError if there is no tool of a name, or if it does not accept the arguments."""
    if name not in QUERIES:
        raise InputError(f"there is no tool {name[:100]!r}: expected one of {', '.join(QUERIES)}")
    _, schema = describe_tool(name)
    for argument, value in arguments.items():
        if argument not in schema["properties"]:
            hint = did_you_mean(argument, schema["properties"])
            raise InputError(f"{name} has no argument {argument[:100]!r}{hint}")
        if not isinstance(value, str):
            raise InputError(f"{argument}: expected a text, found {type(value).__name__}")
    for argument in schema["required"]:
        if argument not in arguments:
            raise InputError(f"{name} needs the argument {argument!r}")
