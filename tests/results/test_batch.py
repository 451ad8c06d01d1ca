from __future__ import annotations

from dataclasses import replace
from itertools import islice

import pytest

from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import RAISED, PlanVerdict
from eai.agents.setting import ACTING
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import Scoring, score_run
from eai.results.options import ScoringOptions
from eai.results.record import NOT_ANSWERED, Record
from eai.results.responses import Response, ResponseFile
from eai.world.fault import FaultKind
from raising import BOOM, NAME
from results.work import TASK_IDS, echo_suite

ANSWERS = ResponseFile("m", tuple(Response(i, f"answer to {i}") for i in TASK_IDS))


def records_of(
    suite: Suite, answers: ResponseFile, *, workers: int = 1, explanations: bool = False
) -> list[Record]:
    with Scoring(workers) as scoring:
        return list(scoring.score_records(suite, answers.model, answers.responses, explanations=explanations))


@pytest.mark.parametrize("workers", [1, 2, 3, 7, 100])
def test_records_come_in_the_order_of_the_answers(workers: int) -> None:
    records = records_of(echo_suite(), ANSWERS, workers=workers)
    assert [record.task_id for record in records] == list(TASK_IDS)
    assert [record.response for record in records] == [r.text for r in ANSWERS.responses]
    assert all(record.verdict == PlanVerdict(success=True) for record in records)
    assert {(record.model, record.protocol, record.data_sha256) for record in records} == {
        ("m", Protocol.STRICT, "0" * 64)
    }


def test_a_suite_that_workers_cannot_open_is_scored_in_this_process() -> None:
    suite = echo_suite()
    suite = replace(suite, benchmark=replace(suite.benchmark, reference=""))
    assert records_of(suite, ANSWERS, workers=4) == records_of(suite, ANSWERS)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_empty_stream_of_answers_gives_no_record(workers: int) -> None:
    assert records_of(echo_suite(), ResponseFile("m", ()), workers=workers) == []


@pytest.mark.parametrize("allow_missing", [False, True])
def test_missing_answers_have_records_in_the_order_of_the_tasks(allow_missing: bool) -> None:
    some = ResponseFile("m", (ANSWERS.responses[4], ANSWERS.responses[1]))
    settings = ScoringOptions(explanations=False, allow_missing=allow_missing)
    records = score_run(echo_suite(), some, {"5_1": "refused", "0_1": "late"}, settings)
    assert [(r.task_id, r.unanswered) for r in records] == [
        ("0_1", "late"),
        ("1_1", None),
        ("4_1", None),
        ("5_1", "refused"),
    ]
    assert {record.suite_size for record in records} == {len(TASK_IDS)}
    lacking = (
        PlanVerdict(excluded=NOT_ANSWERED) if allow_missing else PlanVerdict(executable=False, success=False)
    )
    assert [record.verdict for record in records] == [lacking, *[PlanVerdict(success=True)] * 2, lacking]


@pytest.mark.parametrize("workers", [1, 2])
def test_records_have_explanations_only_on_request(workers: int) -> None:
    first = records_of(echo_suite(), ANSWERS, workers=workers, explanations=True)[0]
    assert first.explanation == VerdictExplanation(notes=("on answer to 0_1",))
    assert records_of(echo_suite(), ANSWERS, workers=workers)[0].explanation is None


def test_a_killed_worker_changes_no_record() -> None:
    many = [Response(TASK_IDS[number % 7], f"answer {number} to {number % 7}_1") for number in range(3_000)]
    suite = echo_suite()
    with Scoring(workers=2) as scoring:
        records = scoring.score_records(suite, "m", many)
        begun = list(islice(records, 20))
        scoring._workers[0].process.kill()
        assert [*begun, *records] == list(Scoring().score_records(suite, "m", many))


@pytest.mark.parametrize(
    ("ability", "workers", "answers", "shares"),
    [
        (Ability.TRANSITION_MODELING, 2, 1_000, (1, 4)),  # a planner may take minutes for each
        (Ability.ACTION_SEQUENCING, 2, 0, (16, 1_024)),  # as many as there may be
        (Ability.ACTION_SEQUENCING, 2, 10, (16, 16)),
        (Ability.ACTION_SEQUENCING, 2, 1_001, (251, 251)),
        (Ability.ACTION_SEQUENCING, 5, 1_000, (100, 100)),
        (Ability.ACTION_SEQUENCING, 0, 200, (100, 100)),
        (Ability.ACTION_SEQUENCING, 2, 100_000, (1_024, 1_024)),
    ],
)
def test_each_worker_gets_two_equal_batches_of_a_known_number_of_answers(
    ability: Ability, workers: int, answers: int, shares: tuple[int, int]
) -> None:
    assert (
        Scoring(workers)._choose_first_and_max_batch_size(replace(echo_suite(), ability=ability), answers)
        == shares
    )


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("ability", [Ability.ACTION_SEQUENCING, ACTING], ids=str)
def test_an_exception_of_a_scorer_affects_only_its_own_answer(ability: Ability, workers: int) -> None:
    suite = open_suite(NAME, ability)
    texts = ["[]", BOOM, *["PRESS(lamp)\nDONE"] * 3]
    answers = [Response(task, text) for task, text in zip(suite.task_ids, texts, strict=True)]
    settings = ScoringOptions(workers=workers)
    records = score_run(suite, ResponseFile("m", tuple(answers)), {}, settings)
    alone = [score_run(suite, ResponseFile("m", (answer,)), {}, ScoringOptions()) for answer in answers]
    assert records == [record for (record,) in alone]
    assert [record.verdict.excluded is None for record in records] == [True, True, True, True, False]
    if ability is Ability.ACTION_SEQUENCING:
        error = records[1].verdict.error
        assert error is not None
        assert (error.check, "OverflowError" in error.detail) == (RAISED, True)
    else:  # only one action of the episode failed
        (turn,) = records[1].verdict.turns  # type: ignore[attr-defined]
        assert (turn.fault, turn.is_action) == (FaultKind.UNCATEGORISED, True)
