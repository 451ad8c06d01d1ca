from __future__ import annotations

import pickle

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import Suite, open_suite
from eai.tasks.source import Source
from protocols import EACH_PROTOCOL
from suites import SUITES

NAMES_ONLY = '{"WALK": ["floor_lamp"]}'
WITH_IDS = '{"WALK": ["floor_lamp", "1000"]}'


def open_plan_suite(store: DataPackStore, protocol: Protocol = Protocol.STRICT, *answers: str) -> Suite:
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING, protocol, source=Source(store))
    return suite.choose_suite_for_answers(answers)


def test_the_suite_of_virtualhome_plans_has_all_tasks(data_store: DataPackStore) -> None:
    suite = open_plan_suite(data_store)
    assert len(suite.task_ids) == 342
    assert (suite.domain, suite.ability) == ("virtualhome", Ability.ACTION_SEQUENCING)
    assert (suite.domain, suite.ability) in SUITES
    assert len(suite.data_sha256) == 64


def test_tasks_without_goals_and_tasks_of_an_erratum_are_excluded(data_store: DataPackStore) -> None:
    suite = open_plan_suite(data_store)
    assert sum(suite.score(task_id, "").excluded is not None for task_id in suite.task_ids) == 4 + 1


def test_a_suite_makes_each_scorer_once(data_store: DataPackStore) -> None:
    suite = open_plan_suite(data_store)
    assert suite.scorer("27_2") is suite.scorer("27_2")


def test_an_error_names_an_unknown_task(data_store: DataPackStore) -> None:
    with pytest.raises(InputError, match="has no task '0_0'"):
        open_plan_suite(data_store).score("0_0", "")


@EACH_PROTOCOL
def test_a_suite_can_be_reopened_in_another_process(data_store: DataPackStore, protocol: Protocol) -> None:
    suite = open_plan_suite(data_store, protocol, WITH_IDS)
    reopened = pickle.loads(pickle.dumps(suite.reopen))()  # noqa: S301 - its own bytes
    assert (reopened.task_ids, reopened.data_sha256, reopened.protocol) == (
        suite.task_ids,
        suite.data_sha256,
        suite.protocol,
    )
    assert reopened.score("11_1", NAMES_ONLY) == suite.score("11_1", NAMES_ONLY)


@EACH_PROTOCOL
def test_a_suite_has_the_features_of_its_tasks(data_store: DataPackStore, protocol: Protocol) -> None:
    """Features also exist for transition modeling, as tasks with one name are near copies there too."""
    source = Source(data_store)
    actions = open_suite("virtualhome", Ability.ACTION_SEQUENCING, protocol, source=source)
    operators = open_suite("virtualhome", Ability.TRANSITION_MODELING, source=source)
    assert actions.features("27_2") == operators.features("27_2") == TaskFeatures("Wash clothes", 14, 5)
    assert len({features.name for i in actions.task_ids if (features := actions.features(i))}) == 26
    activities = open_suite("behavior", Ability.ACTION_SEQUENCING, source=source)
    assert len({features.name for i in activities.task_ids if (features := activities.features(i))}) == 100
