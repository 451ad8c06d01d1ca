from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.verdict import Confusion, GoalVerdict, Verdict
from eai.metrics.bootstrap import Bootstrap
from eai.metrics.comparison import compare, mcnemar
from eai.metrics.rate import Rate
from eai.world.fault import FaultKind
from metrics.verdicts import SUCCEEDED, failed, record

BAD = failed(FaultKind.MISSING_STEP)
BOOTSTRAP = Bootstrap(repetitions=200)


@pytest.mark.parametrize(
    ("lost", "won", "p_value"),
    [(0, 0, 1.0), (1, 1, 1.0), (1, 9, 22 / 1024), (9, 1, 22 / 1024), (0, 5, 2 / 32)],
)
def test_mcnemar(lost: int, won: int, p_value: float) -> None:
    assert mcnemar(lost, won) == pytest.approx(p_value)


def test_mcnemar_of_many_pairs() -> None:
    assert 0 < mcnemar(900, 1000) < 0.05
    assert mcnemar(0, 2000) == 0.0


def test_tasks_that_differ_and_tasks_of_one_run_only() -> None:
    first = [record("a", SUCCEEDED), record("b", BAD), record("c", SUCCEEDED), record("z", BAD)]
    second = [record("c", SUCCEEDED), record("b", SUCCEEDED), record("a", BAD), record("y", BAD)]
    found = compare(first, second, BOOTSTRAP)
    success = found.differences[0]
    assert (success.metric, success.first, success.second) == ("task_success", Rate(2, 3), Rate(2, 3))
    assert (success.only_first, success.only_second) == (("a",), ("b",))
    assert success.test == "exact McNemar"
    assert success.points == 0
    assert found.differing == ("a", "b")
    assert (found.only_in_first, found.only_in_second, found.tasks) == (("z",), ("y",), 3)


def test_f1_is_compared_by_bootstrap() -> None:
    def run(hits: int) -> list[Verdict]:
        return [GoalVerdict(counts={"state": Confusion(hits, 3 - hits, i % 2)}) for i in range(20)]

    first, second = (
        [record(str(i), v, ability=Ability.GOAL_INTERPRETATION) for i, v in enumerate(run(hits))]
        for hits in (1, 3)
    )
    f1 = compare(first, second, BOOTSTRAP).differences[0]
    assert f1.test == "paired bootstrap"
    assert f1.points == pytest.approx(100 * (120 / 130 - 40 / 90))
    assert f1.interval is not None
    assert f1.interval.low > 0
    assert f1.p_value == pytest.approx(2 / 201)


def test_equal_runs_do_not_differ() -> None:
    runs = [record(str(i), SUCCEEDED if i % 3 else BAD) for i in range(9)]
    for difference in compare(runs, runs, BOOTSTRAP).differences:
        assert difference.p_value == 1
        assert difference.interval == (0, 0)
