"""Scoring by actors of a cluster: the same as in one process, whoever is killed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

import eai
from by_path import TESTS
from eai.base.errors import EaiError, InputError
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.batch import Scoring
from eai.results.responses import Response
from results.work import Dying, deadly, failing, squares

ray = pytest.importorskip("ray", reason="Ray is not installed")

from eai.extensions.distributed.ray_scoring import LOCAL, RayScoring  # noqa: E402 - needs it


@pytest.fixture(scope="module")
def cluster() -> Iterator[RayScoring]:
    """Two actors of a cluster that can import the modules of the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(TESTS), prepend=os.pathsep)
        with RayScoring(LOCAL, 2) as scoring:
            yield scoring


def test_records_are_those_of_one_process(cluster: RayScoring, data_store: DataPackStore) -> None:
    suite = eai.open("behavior", "action_sequencing", source=eai.Source(data_store))
    book = open_gold_answers(suite.benchmark, suite.ability)
    answers = [Response(task_id, book[task_id].text) for task_id in suite.task_ids]
    records = list(cluster.score_records(suite, "m", answers, explanations=True))
    assert records == list(Scoring().score_records(suite, "m", answers, explanations=True))


def test_an_actor_that_is_killed_loses_and_doubles_nothing(cluster: RayScoring, tmp_path: Path) -> None:
    assert list(cluster.map_batches(Dying(40, tmp_path / "died"), range(1_000))) == squares(range(1_000))
    assert (tmp_path / "died").exists()
    results = cluster.map_batches(squares, range(5_000), batch_sizes=(16, 64))
    begun = [next(results) for _ in range(100)]
    ray.kill(cluster._workers[0].connection._actor)
    assert [*begun, *results] == squares(range(5_000))


def test_what_fails_or_kills_every_actor_is_named(cluster: RayScoring) -> None:
    with pytest.raises(ValueError, match="no"):
        list(cluster.map_batches(failing, range(5)))
    with pytest.raises(EaiError, match="died 3 times"):
        list(cluster.map_batches(deadly, range(5)))


def test_more_workers_than_cores_are_refused_and_not_waited_for(cluster: RayScoring) -> None:
    with pytest.raises(InputError, match="3 workers need 3 cores, but the cluster has 2"):
        RayScoring(LOCAL, 3)
