from __future__ import annotations

import pytest

from benchmarks.test_suite import NAMES_ONLY, WITH_IDS, open_plan_suite
from eai.abilities.protocol import Protocol
from eai.base.store import DataPackStore


def test_tasks_with_several_relation_goals_are_excluded(data_store: DataPackStore) -> None:
    suite = open_plan_suite(data_store, Protocol("eai-1.0.5"))
    assert sum(suite.score(task_id, "").excluded is not None for task_id in suite.task_ids) == 37


@pytest.mark.parametrize(
    ("answers", "text", "kind"),
    [
        ((NAMES_ONLY,), NAMES_ONLY, None),
        ((NAMES_ONLY,), WITH_IDS, "hallucination"),
        ((WITH_IDS,), NAMES_ONLY, "parsing"),
        ((WITH_IDS,), WITH_IDS, None),
        ((), NAMES_ONLY, None),
        ((), WITH_IDS, None),
    ],
)
def test_under_the_reference_the_answers_decide_how_each_is_read(
    data_store: DataPackStore, answers: tuple[str, ...], text: str, kind: str | None
) -> None:
    error = open_plan_suite(data_store, Protocol("eai-1.0.5"), *answers).score("11_1", text).error
    assert (error and error.kind.value) == kind
    assert open_plan_suite(data_store, Protocol.STRICT, *answers).score("11_1", text).error is None
