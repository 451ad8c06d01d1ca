"""Calls of Ray by the scoring, without Ray: a stand-in executes them."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest

from eai.base.errors import InputError
from results.work import squares

CORES = 3


class Cluster(ModuleType):
    """The part of ``ray`` that the scoring uses. It counts the results that are not yet fetched."""

    def __init__(self) -> None:
        super().__init__("ray")
        self.options: dict[str, int] = {}
        self.actors: list[Any] = []
        self.started: dict[str, Any] | None = None
        self.promised = self.most = 0
        self.complaint, self.fails = "", False

    def is_initialized(self) -> bool:
        return self.started is not None

    def init(self, address: str, **options: Any) -> None:
        os.write(2, self.complaint.encode())
        if self.fails:
            raise ConnectionError("Failed to connect")
        self.started = {"address": address, **options}

    def shutdown(self) -> None:
        self.started = None

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": float(CORES)}

    def remote(self, **options: int) -> Any:
        self.options = options
        return lambda kind: _Remote(lambda: self._actor(kind))

    def _actor(self, kind: Any) -> Any:
        actor, holder = kind(), ModuleType("actor")
        vars(holder)["enter_folder_of_calling_process"] = _Remote(lambda folder: Promise(None))
        vars(holder)["apply_pickled_function_to_batch"] = _Remote(
            lambda content: self._promise(actor, content)
        )
        self.actors.append(holder)
        return holder

    def _promise(self, actor: Any, content: bytes) -> Promise:
        self.promised += 1
        self.most = max(self.most, self.promised)
        return Promise(actor.apply_pickled_function_to_batch(content))

    def get(self, promise: Promise) -> Any:
        self.promised -= 1
        return promise.value

    def wait(
        self, promises: list[Promise], timeout: float | None = None
    ) -> tuple[list[Promise], list[Promise]]:
        return promises[:1], promises[1:]

    def kill(self, actor: Any) -> None:
        self.actors.remove(actor)


class Promise:
    """The result of a call of an actor."""

    def __init__(self, value: Any) -> None:
        self.value = value


class _Remote:
    """A method of an actor."""

    def __init__(self, call: Any) -> None:
        self.remote = call


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    stand_in, errors = Cluster(), ModuleType("ray.exceptions")
    vars(errors)["RayError"] = RuntimeError
    monkeypatch.setitem(sys.modules, "ray", stand_in)
    monkeypatch.setitem(sys.modules, "ray.exceptions", errors)
    monkeypatch.delitem(sys.modules, "eai.extensions.distributed.ray_scoring", raising=False)
    yield stand_in
    sys.modules.pop("eai.extensions.distributed.ray_scoring", None)  # it is bound to the stand-in


def scoring(workers: int | None, address: str = "local") -> Any:
    return import_module("eai.extensions.distributed.ray_scoring").RayScoring(address, workers)


def test_each_actor_has_a_core_and_ends_with_the_block(cluster: Cluster) -> None:
    with scoring(2) as pool:
        assert list(pool.map_batches(squares, range(100))) == squares(range(100))
        assert cluster.options == {"num_cpus": 1}
        assert len(cluster.actors) == 2
        assert cluster.started is not None
        assert cluster.started["num_cpus"] == 2
    assert (cluster.actors, cluster.started) == ([], None)


@pytest.mark.parametrize("workers", [1, 2, CORES])
def test_every_actor_has_work_ahead_and_results_keep_their_order(cluster: Cluster, workers: int) -> None:
    with scoring(workers) as pool:
        assert list(pool.map_batches(squares, range(100), batch_sizes=(1, 2))) == squares(range(100))
    assert cluster.most == workers
    assert cluster.promised == 0


def test_a_cluster_with_fewer_cores_is_left_again(cluster: Cluster) -> None:
    with pytest.raises(InputError, match="4 workers need 4 cores, but the cluster has 3"):
        scoring(CORES + 1)
    assert cluster.started is None


@pytest.mark.parametrize(("items", "actors"), [(1, 1), (10, CORES)])
def test_all_cores_work_by_default_but_none_starts_without_a_batch(
    cluster: Cluster, items: int, actors: int
) -> None:
    with scoring(None) as pool:
        assert list(pool.map_batches(squares, range(items), batch_sizes=(1, 1))) == squares(range(items))
        assert len(cluster.actors) == actors


def test_a_cluster_without_cores_is_left_again(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "cluster_resources", dict)
    with pytest.raises(InputError, match="local: the cluster has no processor cores"):
        scoring(None)
    assert cluster.started is None


def test_one_worker_is_an_actor_too(cluster: Cluster) -> None:
    with scoring(1) as pool:
        assert pool.has_worker_processes


def test_a_port_at_which_nothing_listens_is_not_left_to_ray(cluster: Cluster) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        with scoring(1, address):
            assert cluster.started is not None
    for name in (address, f"ray://{address}"):
        with pytest.raises(InputError, match=f"^{name}: no Ray cluster answers; .*refused"):
            scoring(1, name)


@pytest.mark.parametrize(
    ("complaint", "advice"),
    [("W gcs_client.cc: Unauthenticated", "set RAY_AUTH_MODE=token"), ("W rpc_client.h", "start one")],
)
def test_why_a_cluster_refuses_is_said_in_one_line(
    cluster: Cluster, complaint: str, advice: str, capfd: pytest.CaptureFixture[str]
) -> None:
    cluster.complaint, cluster.fails = complaint, True
    with pytest.raises(InputError, match=f"^auto: .*{advice}"):
        scoring(1, "auto")
    assert capfd.readouterr().err == ""
    assert "RAY_gcs_server_port_wait_time_s" not in os.environ


def test_what_ray_says_of_a_cluster_that_answers_is_shown(
    cluster: Cluster, capfd: pytest.CaptureFixture[str]
) -> None:
    cluster.complaint = "W raylet.cc: little memory"
    with scoring(1, "auto"):
        assert capfd.readouterr().err == cluster.complaint
