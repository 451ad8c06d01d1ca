"""Verdicts under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import pytest

from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.extensions.reference.virtualhome_subgoals import VirtualHomeSubgoalDecompositionScorer
from oracle import MODELS, SUBGOAL_CATEGORIES, Oracle

SETS = (*MODELS, "gold", "perturbed", "perturbed2")
SEEDED = ("gold", "perturbed", "perturbed2")
"""Sets that were made with ``random.seed(0)`` for each row, so that lots are known."""

MOST_CHOICES = 64
"""Maximum number of choices of a row that is compared with all of its choices."""

KINDS = {
    "WRONG_TEMPORAL_ORDER": "wrong_order",
    "MISSING_STEP": "missing_step",
    "AFFORDANCE_ERROR": "affordance",
    "ADDITIONAL_STEP": "additional_step",
}


def of_reference(row: Mapping[str, Any]) -> tuple[object, ...]:
    """Return the reference's verdict on a row in our terms: category, errors or findings, goals."""
    category, report = SUBGOAL_CATEGORIES[row["category"]], row["report"]
    if category == "not_parseable":
        return (category,)
    if category == "hallucination":
        if report[0].get("error_type") == "UnknownPrimitive":
            return (category, {"unknown_predicate"})
        found = {"wrong_arity": "IncorrectParamLength", "unknown_object": "ObjectNotInScene"}
        return (category, {ours for ours, theirs in found.items() if report[0][theirs]})
    noted = [entry["error_info"]["error_type"][0] for entry in report[-2]]
    tallies = report[-1]
    goals = [(tallies[f"{k}_success_num"], tallies[f"{k}_tot_num"]) for k in ("node", "edge", "action")]
    return (category, [KINDS[kind] for kind in noted if kind != "GOAL_FAILED"], goals)


def of_ours(verdict: SubgoalVerdict) -> tuple[object, ...]:
    assert verdict.category is not None
    category = verdict.category.value
    if category == "not_parseable":
        return (category,)
    if category == "hallucination":
        offences = set(verdict.offences)
        return (category, {"unknown_predicate"} if "unknown_predicate" in offences else offences)
    assert verdict.goals is not None
    return (category, [kind.value for kind in verdict.errors], [tuple(tally) for tally in verdict.goals])


@pytest.mark.parametrize("name", SETS)
def test_every_row_without_lots_has_the_verdict_of_the_reference(
    name: str, oracle: Oracle, virtualhome_tasks: VirtualHomeTasks
) -> None:
    differing, compared = {}, 0
    for row in oracle("virtualhome", "subgoal_decomposition", name)["tasks"]:
        if not row["has_or"]:
            ours = of_ours(score(virtualhome_tasks, row["id"], row["llm_output"]))
            compared += 1
            if ours != of_reference(row):
                differing[row["id"]] = (of_reference(row), ours)
    assert differing == {}
    assert compared >= 250


@pytest.mark.parametrize("name", SETS)
def test_a_row_with_lots_has_the_verdict_of_some_choice(
    name: str, oracle: Oracle, virtualhome_tasks: VirtualHomeTasks
) -> None:
    missing = {}
    for row in oracle("virtualhome", "subgoal_decomposition", name)["tasks"]:
        if row["has_or"]:
            possible = [
                of_ours(score(virtualhome_tasks, row["id"], text)) for text in choices(row["llm_output"])
            ]
            if possible and of_reference(row) not in possible:
                missing[row["id"]] = (of_reference(row), possible)
    assert missing == {}


@pytest.mark.parametrize("name", SEEDED)
def test_a_row_with_known_lots_has_the_verdict_of_the_reference(
    name: str, oracle: Oracle, virtualhome_tasks: VirtualHomeTasks
) -> None:
    rows = [r for r in oracle("virtualhome", "subgoal_decomposition", name)["tasks"] if r["has_or"]]
    scored = {row["id"]: of_ours(score(virtualhome_tasks, row["id"], row["llm_output"])) for row in rows}
    assert {r["id"]: scored[r["id"]] for r in rows if scored[r["id"]] != of_reference(r)} == {}


def score(tasks: VirtualHomeTasks, row_id: str, text: str) -> SubgoalVerdict:
    return VirtualHomeSubgoalDecompositionScorer(tasks[row_id.partition("@")[0]]).score(text)


def choices(text: str) -> Iterator[str]:
    """The answers with one piece of each text that has `` or ``; none if they are many."""
    found = re.search(r"{[^{}]*}", text.strip().replace("}}", "}"), re.DOTALL)
    try:
        output = json.loads(found.group())["output"] if found is not None else []
    except (ValueError, KeyError):
        output = []
    if not output:
        yield text
        return
    pieces = [subgoal.strip().split(" or ") for subgoal in output]
    number = 1
    for options in pieces:
        number *= len(options)
    if number <= MOST_CHOICES:
        for choice in product(*pieces):
            yield json.dumps({"output": choice})
