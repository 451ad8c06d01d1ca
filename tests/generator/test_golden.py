"""The tasks of some seeds, of all kinds of specifications, are those that they have been.

A change of what is generated is meant or a mistake: if it is meant, the version of the generator is another.
"""

from __future__ import annotations

import hashlib
from itertools import islice
from pathlib import Path

import pytest

from eai.benchmark.registry import find_benchmark
from eai.data.store import Store
from eai.generator.generator import Generator
from eai.generator.measures import AtLeast, Measure
from eai.generator.sets import Seeds
from eai.generator.spec import Forms, Generated, Rejected, Spec, Tier
from eai.tasks.source import Source
from eai.tasks.task_lines import written
from generator.worlds import HOUSEHOLDS
from golden_files import assert_golden

SPECS = {
    "data": {},
    "all forms": {"forms": Forms.ALL, "tier": Tier.M},
    "actions, over time": {"actions": True, "over_time": True},
    "by place": {"by_place": True, "forms": Forms.ALL},
    "hidden": {"at_least": (AtLeast(Measure.HIDDEN, 1),)},
    "little": {"tier": Tier.S, "disturbances": 0, "most_objects": 8, "depth": 2},
}
SEEDS, TASKS = 40, 4
"""How many seeds are asked of each at most, and how many tasks end it."""


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_equal_seeds_give_what_they_have_given(like: str, data_store: Store) -> None:
    benchmark, source = find_benchmark(like), Source()
    lines = []
    for name, options in SPECS.items():
        made = Generator(benchmark, Spec(like, benchmark.tasks(source).sha256, **options), source)  # type: ignore[arg-type]
        tasks = 0
        for seed in islice(Seeds("golden", 0), SEEDS):
            if tasks == TASKS:
                break
            outcome = made.task(seed)
            tasks += isinstance(outcome, Generated)
            if isinstance(outcome, Rejected):
                lines.append(f"{name} {seed}: {outcome.reason.value}")
                continue
            line = written(outcome.task, like, benchmark.domain, outcome.about)
            digest = hashlib.sha256(line.encode()).hexdigest()[:12]
            lines.append(f"{name} {seed}: {len(outcome.task.script)} steps, {digest}")
    assert_golden(Path(__file__).with_name(f"golden_{like}.txt"), lines)
