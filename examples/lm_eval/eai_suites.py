"""The suites of eai as tasks of the LM Evaluation Harness, each question asked once.

    lm_eval --include_path examples/lm_eval --tasks eai_behavior_action_sequencing --model dummy

A metric is the sum of its numerators divided by the sum of its denominators, as in all of eai. Answers to
tasks that the protocol excludes do not count.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import datasets

import eai
from eai import Ability, Suite
from eai.abilities.declaration import get_declaration
from eai.benchmarks.prompt_library import PromptLibrary
from eai.results.summary import compute_metric_contributions


@cache
def suite_of(domain: str, ability: str) -> Suite:
    """Return the suite, whose tasks are made once."""
    return eai.open(domain, ability)


def questions(domain: str, ability: str, **_: object) -> dict[str, datasets.Dataset]:
    """Return the official prompts of a suite, one row each, in the split ``test``."""
    suite = suite_of(domain, ability)
    asked = PromptLibrary("official", None, suite.source).open(suite.benchmark, Ability(ability))
    about = {"domain": domain, "ability": ability}
    rows = [
        {**about, "task_id": task_id, "system": prompt.system or "", "user": prompt.user}
        for task_id, prompt in asked.items()
    ]
    return {"test": datasets.Dataset.from_list(rows)}


def text(row: Mapping[str, str]) -> str:
    """Return a question as one text, its system message first."""
    return f"{row['system']}\n\n{row['user']}" if row["system"] else row["user"]


def shares(row: Mapping[str, str], answers: Sequence[str]) -> dict[str, Any]:
    """Return the numerator and denominator that an answer adds to each main metric."""
    ability = Ability(row["ability"])
    verdict = suite_of(row["domain"], row["ability"]).score(row["task_id"], answers[0])
    counted = compute_metric_contributions([verdict], ability)
    return {
        name: tuple(each[name]) for each in counted for name in get_declaration(ability).overview_headings
    }


def rate(counted: Sequence[tuple[float, float]]) -> float:
    """Return a metric from 0 to 1, or 0 if no answer counts."""
    whole = sum(share[1] for share in counted)
    return sum(share[0] for share in counted) / whole if whole else 0.0
