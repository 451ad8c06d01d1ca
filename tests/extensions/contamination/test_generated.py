"""Generated tasks with swapped names: their abilities, and the names in answers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import eai
from benchmarks.generator import test_ambiguity
from benchmarks.generator.worlds import pairs
from eai.abilities.declining import read_refusal_reason
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.tasks.special import PossiblyImpossibleTaskMark
from eai.tasks.task_lines import write_task_line

pytestmark = pytest.mark.usefixtures("data_store")


def test_in_other_words_what_is_missing_is_said_in_these(tmp_path: Path) -> None:
    domain = find_benchmark("behavior").domain
    twin = pairs("behavior")[0].paired
    assert twin is not None
    (tmp_path / "tasks.jsonl").write_text(write_task_line(twin.task, "behavior", domain), encoding="utf-8")
    other = find_benchmark(f"obfuscated:{tmp_path}/")
    gold = open_gold_answers(other, Ability.ACTION_SEQUENCING)[twin.task.id].text
    assert isinstance(twin.task.special, PossiblyImpossibleTaskMark)
    (missing,) = twin.task.special.missing
    assert read_refusal_reason(gold) != missing
    verdict = eai.open(other, Ability.ACTION_SEQUENCING).score(twin.task.id, gold)
    assert isinstance(verdict, PlanVerdict)
    assert (verdict.success, verdict.refused) == (True, missing)


def test_tasks_whose_words_may_fit_two_objects_are_not_asked_for(tmp_path: Path) -> None:
    domain = find_benchmark("behavior").domain
    (clear, unclear), *_ = test_ambiguity.pairs("behavior")
    plain = replace(clear, id="plain", special=None)
    lines = [write_task_line(task, "behavior", domain) for task in (clear, unclear, plain)]
    (tmp_path / "tasks.jsonl").write_text("\n".join(lines), encoding="utf-8")
    twin = find_benchmark(f"obfuscated:{tmp_path}/")
    for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        assert list(twin.tasks_for(ability, Source())) == ["plain"]
