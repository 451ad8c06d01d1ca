"""Streams of work in several processes: order, reading ahead, and dying workers."""

from __future__ import annotations

import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from multiprocessing import active_children
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import eai
from eai.base.errors import EaiError
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.batch import Scoring
from eai.results.reward import Reward
from eai.results.workers import (
    MAX_BATCH_SIZE,
    MAX_BATCHES_AHEAD,
    MAX_DEATHS,
    WorkerPool,
    WorkerProcess,
    _remove_folder,
    _WorkBatch,
    split_batches,
)
from results.work import Dying, asleep, cubes, deadly, failing, folder_of_files, large, squares, unspeakable


@pytest.mark.parametrize("workers", [1, 2, 3])
@pytest.mark.parametrize("number", [0, 1, 15, 1_000])
def test_results_come_in_order(workers: int, number: int) -> None:
    with WorkerPool(workers) as pool:
        for work in (squares, cubes, squares):  # the same processes, other work
            assert list(pool.map_batches(work, range(number))) == work(range(number))


@pytest.mark.parametrize(
    ("workers", "sizes"),
    [(1, [2, 4, 8, 10, 10, 6]), (2, [2, 2, 4, 4, 8, 8, 10, 2]), (3, [2] * 3 + [4] * 3 + [8, 8, 6])],
)
def test_batches_grow_after_each_worker_has_had_one(workers: int, sizes: list[int]) -> None:
    made = list(split_batches(range(40), workers, 2, 10))
    assert [len(batch) for batch in made] == sizes
    assert [item for batch in made for item in batch] == list(range(40))


def test_only_a_few_batches_are_read_ahead() -> None:
    taken = 0

    def endless() -> Iterator[int]:
        nonlocal taken
        while True:
            taken += 1
            yield taken

    with WorkerPool(2) as pool:
        results = pool.map_batches(squares, endless())
        for count in (1, 5_000, 20_000):
            before = taken
            assert len(list(islice(results, count))) == count
            assert taken - before <= count + (2 * MAX_BATCHES_AHEAD + 1) * MAX_BATCH_SIZE


@pytest.mark.parametrize("at", [0, 40, 999])
def test_a_killed_worker_loses_and_repeats_no_result(tmp_path: Path, at: int) -> None:
    with WorkerPool(2) as pool:
        assert list(pool.map_batches(Dying(at, tmp_path / "died"), range(1_000))) == squares(range(1_000))
        assert (tmp_path / "died").exists()
        assert list(pool.map_batches(squares, range(100))) == squares(range(100))


def test_workers_killed_between_two_streams_are_replaced() -> None:
    with WorkerPool(2) as pool:
        assert list(pool.map_batches(squares, range(100))) == squares(range(100))
        for worker in pool._workers:
            worker.process.kill()
        assert list(pool.map_batches(squares, range(100))) == squares(range(100))


@pytest.mark.parametrize("place", [0, 1])
def test_a_worker_killed_while_sending_blocks_no_other(place: int) -> None:
    with WorkerPool(2) as pool:
        results = pool.map_batches(large, range(12), batch_sizes=(1, 1))
        next(results)
        taken = 1
        while not pool._workers[place].pending:  # the worker that started first may have done all batches
            next(results)
            taken += 1
        sends = pool._workers[place]
        assert sends.connection.poll(600), "it has begun, and a pipe holds a small part"
        sends.process.kill()
        assert sum(1 for _ in results) == 12 - taken


def test_streams_may_be_interleaved_and_abandoned(tmp_path: Path) -> None:
    with WorkerPool(2) as pool:
        first = pool.map_batches(squares, range(500))
        second = pool.map_batches(Dying(3, tmp_path / "died"), range(90))
        left = pool.map_batches(cubes, range(10_000))
        next(left)
        left.close()
        mixed = [(next(first), next(second)) for _ in range(90)]
        assert mixed == list(zip(squares(range(90)), squares(range(90)), strict=True))
        assert list(first) == squares(range(90, 500))
        assert not pool._waiting


def test_closing_the_workers_ends_their_streams() -> None:
    with WorkerPool(2) as pool:
        results = pool.map_batches(squares, range(500))
        next(results)
        pool.close()
        with pytest.raises(EaiError, match="closed before"):
            list(results)


def test_temporary_files_of_workers_are_removed() -> None:
    with WorkerPool(2) as pool:
        left = {
            Path(file).parent for file in pool.map_batches(folder_of_files, range(40), batch_sizes=(1, 1))
        }
        assert len(left) == 40
        assert all(folder.is_dir() for folder in left)
        pool._workers[0].process.kill()
    assert not any(folder.parent.exists() for folder in left)


@pytest.mark.parametrize(("seconds", "stays"), [(60, False), (0, True)])
def test_removing_a_folder_is_retried_until_the_time_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seconds: int, stays: bool
) -> None:
    class Written(TemporaryDirectory[str]):
        """A folder in which a file appears again after two removals."""

        times = 0

        def cleanup(self) -> None:
            self.times += 1
            if self.times == 3:
                super().cleanup()

    monkeypatch.setattr("eai.results.workers.CLEANING_SECONDS", seconds)
    folder = Written(dir=tmp_path)
    _remove_folder(folder)
    assert Path(folder.name).exists() is stays
    TemporaryDirectory.cleanup(folder)


def test_items_that_kill_every_worker_are_named() -> None:
    with (
        WorkerPool(2) as pool,
        pytest.raises(EaiError, match=f"died {MAX_DEATHS} times at the same 16 items"),
    ):
        list(pool.map_batches(deadly, range(20)))


def test_an_error_in_a_worker_is_raised_in_the_caller() -> None:
    with WorkerPool(2) as pool, pytest.raises(ValueError, match="no"):
        list(pool.map_batches(failing, range(5)))
    with WorkerPool(2) as pool, pytest.raises(EaiError, match="UnspeakableError: of no module"):
        list(pool.map_batches(unspeakable, range(5)))


def test_an_interrupt_ends_busy_workers() -> None:
    def items() -> Iterator[int]:
        yield from range(4)
        assert active_children()
        raise KeyboardInterrupt

    with WorkerPool(2) as pool, pytest.raises(KeyboardInterrupt):
        next(pool.map_batches(asleep, items(), batch_sizes=(1, 1)))
    assert not active_children()


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_the_fork_server_ignores_interrupts() -> None:
    script = (
        "from multiprocessing.forkserver import _forkserver\n"
        "from pathlib import Path\n"
        "from eai.results.workers import WorkerPool\n"
        "with WorkerPool(2) as pool:\n"
        "    list(pool.map_batches(list, range(3)))\n"
        "    print(Path(f'/proc/{_forkserver._forkserver_pid}/status').read_text())\n"
    )
    status = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    (held,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigBlk:"))
    assert int(held, 16) >> (signal.SIGINT - 1) & 1  # from its first moment on, not only once it ignores them


def test_rewards_from_workers_are_the_same(data_store: DataPackStore) -> None:
    suite = eai.open("behavior", "action_sequencing", source=eai.Source(data_store))
    book = open_gold_answers(suite.benchmark, suite.ability)
    answers = [(task_id, book[task_id].text) for task_id in suite.task_ids] * 3
    reward = Reward(suite, "diagnosis")
    with Scoring(workers=2) as scoring:
        assert list(scoring.compute_rewards(reward, answers)) == [reward(*answer) for answer in answers]


class Noted:
    """A process with its pipe; it only notes the messages that it gets."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []
        self.connection = self.process = self

    def send_bytes(self, content: bytes) -> None:
        self.sent.append(content)


def given_out(monkeypatch: pytest.MonkeyPatch, workers: int, sizes: list[int]) -> list[int]:
    """Return the number of batches that each started process has, and the number that wait."""
    monkeypatch.setattr(WorkerPool, "_start_worker", lambda self: WorkerProcess(Noted(), Noted()))  # type: ignore[arg-type]
    pool = WorkerPool(workers)
    for size in sizes:
        pool._waiting.append(_WorkBatch(b"", tuple(range(size))))
        pool._send_batches()
    assert all(len(worker.connection.sent) == len(worker.pending) for worker in pool._workers)  # type: ignore[attr-defined]
    return [*(len(worker.pending) for worker in pool._workers), len(pool._waiting)]


@pytest.mark.parametrize(
    ("workers", "sizes", "expected"),
    [
        (3, [], [0]),
        (3, [16], [1, 0]),
        (3, [16] * 2, [1, 1, 0]),
        (3, [16] * 4, [2, 1, 1, 0]),
        (3, [16] * 8, [2, 2, 2, 2]),
        (2, [15] * 3, [1, 1, 1]),  # small batches wait for a free worker
        (2, [16, 16, 15], [1, 1, 1]),
        (2, [16, 15, 16], [2, 1, 0]),
    ],
)
def test_batches_go_to_the_least_busy_worker(
    monkeypatch: pytest.MonkeyPatch, workers: int, sizes: list[int], expected: list[int]
) -> None:
    assert given_out(monkeypatch, workers, sizes) == expected


@pytest.mark.parametrize(("workers", "read"), [(2, 24), (3, 36)])
def test_three_batches_for_each_worker_are_read_ahead(
    monkeypatch: pytest.MonkeyPatch, workers: int, read: int
) -> None:
    taken: list[int] = []

    def received(self: WorkerPool) -> None:
        for batch in self._waiting:
            batch.result = pickle.dumps(list(batch.items))
        self._waiting.clear()

    monkeypatch.setattr(WorkerPool, "_send_batches", lambda self: None)
    monkeypatch.setattr(WorkerPool, "_receive_result", received)
    results = WorkerPool(workers).map_batches(
        squares, (taken.append(n) or n for n in range(99)), batch_sizes=(4, 4)
    )
    assert next(results) == 0
    assert len(taken) == read
    assert list(islice(results, 4)) == [1, 2, 3, 4]
    assert len(taken) == read + 4
    assert list(results) == list(range(5, 99))


def test_a_folder_of_workers_is_removed_even_if_files_appear_in_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[dict[str, object]] = []

    class Folder(TemporaryDirectory[str]):
        def __init__(self, **options: object) -> None:
            made.append(options)
            super().__init__(**options)  # type: ignore[call-overload]

    monkeypatch.setattr("eai.results.workers.TemporaryDirectory", Folder)
    with WorkerPool(2) as pool:
        assert list(pool.map_batches(squares, range(9))) == squares(range(9))
    assert made == [{"prefix": "eai-workers-", "ignore_cleanup_errors": True}]
