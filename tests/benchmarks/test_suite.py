from __future__ import annotations

import pickle

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.base.errors import InputError
from eai.base.store import Store
from eai.benchmarks.suite import Suite, open_suite
from eai.tasks.source import Source
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


def test_the_protocols_exclude_different_tasks(data_store: Store) -> None:
    def excluded(protocol: Protocol) -> int:
        suite = opened(data_store, protocol)
        return sum(suite.score(task_id, "").excluded is not None for task_id in suite.task_ids)

    # Four tasks without a goal, and one that an erratum leaves out; those with two relation goals or more.
    assert (excluded(Protocol.STRICT), excluded(Protocol("eai-1.0.5"))) == (5, 37)


def test_a_scorer_is_made_once(data_store: Store) -> None:
    suite = opened(data_store)
    assert suite.scorer("27_2") is suite.scorer("27_2")


def test_an_unknown_task_is_named(data_store: Store) -> None:
    with pytest.raises(InputError, match="has no task '0_0'"):
        opened(data_store).score("0_0", "")


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
    data_store: Store, answers: tuple[str, ...], text: str, kind: str | None
) -> None:
    error = opened(data_store, Protocol("eai-1.0.5"), *answers).score("11_1", text).error
    assert (error and error.kind.value) == kind
    assert opened(data_store, Protocol.STRICT, *answers).score("11_1", text).error is None


def test_a_suite_can_be_opened_again_elsewhere(data_store: Store) -> None:
    suite = opened(data_store, Protocol("eai-1.0.5"), WITH_IDS)
    twin = pickle.loads(pickle.dumps(suite.reopen))()  # noqa: S301 - its own bytes
    assert (twin.task_ids, twin.data_sha256, twin.protocol) == (
        suite.task_ids,
        suite.data_sha256,
        suite.protocol,
    )
    assert twin.score("11_1", NAMES_ONLY) == suite.score("11_1", NAMES_ONLY)


def test_a_suite_says_what_its_tasks_are_like(data_store: Store) -> None:
    """Also of tasks that ask for operators: tasks of one name are near copies there too."""
    source = Source(data_store)
    actions = open_suite("virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"), source=source)
    operators = open_suite("virtualhome", Ability.TRANSITION_MODELING, source=source)
    assert actions.features("27_2") == operators.features("27_2") == TaskFeatures("Wash clothes", 14, 5)
    assert len({found.name for i in actions.task_ids if (found := actions.features(i))}) == 26
    activities = open_suite("behavior", Ability.ACTION_SEQUENCING, source=source)
    assert len({found.name for i in activities.task_ids if (found := activities.features(i))}) == 100
