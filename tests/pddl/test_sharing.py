from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

import pytest

from eai.pddl.sharing import Seats, machine_memory_mib


def test_no_more_planners_run_at_a_time_than_there_are_seats(tmp_path: Path) -> None:
    lock, running, most = Lock(), 0, 0

    def work(number: int) -> int:
        nonlocal running, most
        with Seats(3, tmp_path).taken():
            with lock:
                running += 1
                most = max(most, running)
            total = sum(range(200_000))
            with lock:
                running -= 1
        return total

    with ThreadPoolExecutor(30) as pool:
        assert len(list(pool.map(work, range(30)))) == 30
    assert 1 <= most <= 3


def test_a_seat_is_given_back_by_whoever_fails(tmp_path: Path) -> None:
    def fail() -> None:
        with Seats(1, tmp_path).taken():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    with Seats(1, tmp_path).taken():
        pass


def test_the_machine_has_memory() -> None:
    assert machine_memory_mib() > 64
