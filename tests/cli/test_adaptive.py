from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.verdict import PlanVerdict
from eai.benchmark.suite import Suite, open_suite
from eai.cli import order
from eai.cli.order import Order
from eai.data.store import Store
from eai.run.spec import RunSpec
from eai.studies.variation import Endpoint
from eai.tasks.adaptive import item_difficulties
from eai.tasks.source import Source
from results.verdicts import SUCCEEDED, record

SUITE = ("behavior", Ability.ACTION_SEQUENCING)


@dataclass
class Result:
    """As much of a run's result as is looked at."""

    folder: Path
    suite: Suite
    records: list[Record]
    failures: dict[str, list[str]]
    model: str = "m"


@pytest.mark.parametrize("excluded", [True, False])
def test_what_does_not_count_is_asked_once_and_says_nothing(
    data_store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, excluded: bool
) -> None:
    """A task that is left out of statistics, and one that cannot be answered, which ends the run."""
    suite = open_suite(*SUITE, source=Source(data_store))
    odd = min(known := item_difficulties(*SUITE), key=lambda task: (abs(known[task]), task))
    rounds: list[list[str]] = []

    def obtained(_: Order, endpoint: Endpoint, prompts: Mapping[str, Any], of: Suite) -> Result:
        rounds.append(list(prompts))
        records = [record(task, SUCCEEDED, domain=of.domain) for task in prompts]
        changes = {"verdict": PlanVerdict(excluded="no solution")} if excluded else {"unanswered": "timeout"}
        records = [replace(each, **changes) if each.task_id == odd else each for each in records]
        return Result(tmp_path, of, records, {} if excluded else {"timeout": [odd]})

    monkeypatch.setattr(order, "obtain_and_score", obtained)
    prompts = dict.fromkeys(suite.task_ids)
    run = Order(RunSpec(), tmp_path, quiet=True)
    order.obtain_adaptively(run, cast(Any, None), cast(Any, prompts), suite, 0.6)
    assert odd in rounds[0]
    sizes = [len(asked) for asked in rounds]
    assert sizes == [5 * number for number in range(1, len(rounds) + 1)]
    assert (len(rounds) == 1) == (not excluded)
