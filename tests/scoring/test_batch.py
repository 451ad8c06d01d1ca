from __future__ import annotations

import time
from dataclasses import dataclass, replace
from multiprocessing import active_children

import pytest

from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.responses import Response, ResponseFile
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite
from eai.scoring.batch import score_batch, worker_pool

BENCHMARK = find_benchmark("virtualhome")
TASK_IDS = tuple(f"{number}_1" for number in range(7))
ANSWERS = ResponseFile("m", tuple(Response(i, f"answer to {i}") for i in TASK_IDS))


@dataclass(frozen=True, slots=True)
class Echo(Scorer):
    """A scorer that says what it was asked."""

    task_id: str

    def assess(self, text: str) -> Assessment:
        verdict = PlanVerdict(success=text.endswith(self.task_id))
        return Assessment(verdict, lambda: Explanation(notes=(f"on {text}",)))


def echo_suite() -> Suite:
    suite = Suite(BENCHMARK, Ability.ACTION_SEQUENCING, Protocol.STRICT, TASK_IDS, "0" * 64, Echo)
    return replace(suite, reopen=echo_suite)


@pytest.mark.parametrize("workers", [1, 2, 3, 7, 100])
def test_records_come_in_the_order_of_the_answers(workers: int) -> None:
    records = score_batch(echo_suite(), ANSWERS, workers=workers)
    assert [record.task_id for record in records] == list(TASK_IDS)
    assert [record.response for record in records] == [r.text for r in ANSWERS.responses]
    assert all(record.verdict == PlanVerdict(success=True) for record in records)
    assert {(record.model, record.protocol, record.data_sha256) for record in records} == {
        ("m", Protocol.STRICT, "0" * 64)
    }


def test_a_suite_that_cannot_be_opened_again_is_scored_here() -> None:
    suite = replace(echo_suite(), reopen=None)
    assert score_batch(suite, ANSWERS, workers=4) == score_batch(suite, ANSWERS)


@pytest.mark.parametrize("workers", [1, 2])
def test_nothing_to_score_gives_no_record(workers: int) -> None:
    assert score_batch(echo_suite(), ResponseFile("m", ()), workers=workers) == []


@pytest.mark.parametrize("workers", [1, 2])
def test_explanations_stand_in_the_records_where_they_are_asked_for(workers: int) -> None:
    first = score_batch(echo_suite(), ANSWERS, workers=workers, explanations=True)[0]
    assert first.explanation == Explanation(notes=("on answer to 0_1",))
    assert score_batch(echo_suite(), ANSWERS, workers=workers)[0].explanation is None


def test_an_interrupt_ends_workers_whatever_they_do() -> None:
    def interrupted() -> None:
        with worker_pool(2) as pool:
            pool.submit(time.sleep, 3600)
            raise KeyboardInterrupt

    before = active_children()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert set(active_children()) <= set(before)
