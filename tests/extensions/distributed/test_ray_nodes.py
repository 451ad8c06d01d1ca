"""Score on a cluster of two nodes, and kill one node: records equal those of one process."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest

import eai
from by_path import TESTS
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.batch import Scoring
from eai.results.records import format_record_line
from eai.results.responses import Response
from results.work import squares

ray = pytest.importorskip("ray", reason="Ray is not installed")

from ray.cluster_utils import Cluster  # noqa: E402 - needs it

from eai.extensions.distributed.ray_scoring import RayScoring  # noqa: E402 - needs it

NODE = {"num_cpus": 1, "object_store_memory": 80_000_000, "include_dashboard": False}


@pytest.fixture
def nodes(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A cluster of one node that finds the modules of the tests."""
    monkeypatch.setenv("PYTHONPATH", str(TESTS), prepend=os.pathsep)
    cluster = Cluster(initialize_head=True, head_node_args=NODE)
    yield cluster
    cluster.shutdown()


def test_a_node_that_is_killed_loses_and_doubles_nothing(nodes: Any, data_store: DataPackStore) -> None:
    second = nodes.add_node(num_cpus=1, object_store_memory=NODE["object_store_memory"])
    suite = eai.open("virtualhome", "action_sequencing", source=eai.Source(data_store))
    book = open_gold_answers(suite.benchmark, suite.ability)
    answers = [Response(task_id, book[task_id].text) for task_id in suite.task_ids] * 5
    with RayScoring(nodes.address, 2) as scoring:
        assert list(scoring.map_batches(squares, range(100))) == squares(range(100))
        workers: list[Any] = list(scoring._workers)
        ray.get([each.connection._start for each in workers if each.connection._start is not None])
        records = scoring.score_records(suite, "m", (answer for answer in answers))
        lines = [format_record_line(next(records)) for _ in range(50)]
        nodes.remove_node(second, allow_graceful=False)
        lines += map(format_record_line, records)
        assert lines == [*map(format_record_line, Scoring().score_records(suite, "m", answers))]
        assert len({*workers} - {*scoring._workers}) == 1
