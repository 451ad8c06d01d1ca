"""Domains that use what the collection of the planning competitions does: each opens and is scored right."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.planning.planner import Planner
from eai.tasks.planning import find_plan

FOLDER = Path(__file__).parent / "constructs"


@pytest.mark.parametrize("name", sorted(each.name for each in FOLDER.iterdir()))
def test_a_domain_of_unusual_form_opens_and_its_plan_wins(name: str) -> None:
    place = FOLDER / name
    suite = open_suite(find_benchmark(f"pddl:{place}/domain.pddl,{place}/p.pddl"), Ability.ACTION_SEQUENCING)
    (task,) = suite.tasks.values()
    plan = find_plan(task, Planner(suite.benchmark.domain)).plan
    things = [each.name for each in task.scene.objects]
    lines = [f"({' '.join([each.operator, *(things[i] for i in each.arguments)])})" for each in plan]
    assert lines

    def wins(steps: list[str]) -> bool:
        verdict = suite.scorer(task.id).score("\n".join(steps).upper())
        assert isinstance(verdict, PlanVerdict)
        return bool(verdict.success)

    assert wins(lines)
    assert len(lines) == 1 or not wins(lines[:-1])
