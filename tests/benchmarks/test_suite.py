from __future__ import annotations

import pickle

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.base.errors import InputError
from eai.base.store import Store
from eai.benchmarks.suite import Suite, open_suite
from eai.tasks.source import Source
from protocols import EACH_PROTOCOL
from suites import SUITES

NAMES_ONLY = '{"WALK": ["floor_lamp"]}'
WITH_IDS = '{"WALK": ["floor_lamp", "1000"]}'


def opened(store: Store, protocol: Protocol = Protocol.STRICT, *answers: str) -> Suite:
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING, protocol, source=Source(store))
    return suite.over(answers)


def test_action_sequencing_in_virtualhome_has_all_tasks(data_store: Store) -> None:
    suite = opened(data_store)
    assert len(suite.task_ids) == 342
    assert (suite.domain, suite.ability) == ("virtualhome", Ability.ACTION_SEQUENCING)
    assert (suite.domain, suite.ability) in SUITES
    assert len(suite.data_sha256) == 64


def test_tasks_without_goals_and_tasks_of_an_erratum_are_excluded(data_store: Store) -> None:
    suite = opened(data_store)
    assert sum(suite.score(task_id, "").excluded is not None for task_id in suite.task_ids) == 4 + 1


def test_a_scorer_is_made_once(data_store: Store) -> None:
    suite = opened(data_store)
    assert suite.scorer("27_2") is suite.scorer("27_2")


def test_an_unknown_task_is_named(data_store: Store) -> None:
    with pytest.raises(InputError, match="has no task '0_0'"):
        opened(data_store).score("0_0", "")


@EACH_PROTOCOL
def test_a_suite_can_be_opened_again_elsewhere(data_store: Store, protocol: Protocol) -> None:
    suite = opened(data_store, protocol, WITH_IDS)
    twin = pickle.loads(pickle.dumps(suite.reopen))()  # noqa: S301 - its own bytes
    assert (twin.task_ids, twin.data_sha256, twin.protocol) == (
        suite.task_ids,
        suite.data_sha256,
        suite.protocol,
    )
    assert twin.score("11_1", NAMES_ONLY) == suite.score("11_1", NAMES_ONLY)


@EACH_PROTOCOL
def test_a_suite_says_what_its_tasks_are_like(data_store: Store, protocol: Protocol) -> None:
    """Also of tasks that ask for operators: tasks of one name are near copies there too."""
    source = Source(data_store)
    actions = open_suite("virtualhome", Ability.ACTION_SEQUENCING, protocol, source=source)
    operators = open_suite("virtualhome", Ability.TRANSITION_MODELING, source=source)
    assert actions.features("27_2") == operators.features("27_2") == TaskFeatures("Wash clothes", 14, 5)
    assert len({found.name for i in actions.task_ids if (found := actions.features(i))}) == 26
    activities = open_suite("behavior", Ability.ACTION_SEQUENCING, source=source)
    assert len({found.name for i in activities.task_ids if (found := activities.features(i))}) == 100
