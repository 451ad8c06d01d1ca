"""The predicates of the reference: those that are the paper's, and those that depend on a hash table."""

from __future__ import annotations

import pytest

from benchmarks.virtualhome.test_predicates import (
    ON_SHELVES,
    is_remembered_after_grabbing,
    test_a_room_is_found_through_the_only_container,
    test_an_object_in_a_room_has_that_room,
    test_only_the_first_relation_that_holds_defines_the_place_of_an_object,
)
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.extensions.reference import virtualhome_quirks
from eai.world.domain import Domain

SHARED = (
    test_a_room_is_found_through_the_only_container,
    test_an_object_in_a_room_has_that_room,
    test_only_the_first_relation_that_holds_defines_the_place_of_an_object,
)
"""Tests of the paper's predicates, which are run again with the fixture `domain` below."""

REFERENCE = virtualhome_quirks.make_domain_with_all_quirks()


@pytest.fixture
def domain() -> Domain:
    return REFERENCE


def test_of_several_places_the_first_in_a_hash_table_counts() -> None:
    """Python iterates a set of 90 and 128 as 128, 90: they are in slots 0 and 2 of 8."""
    remembered = [
        name
        for name in ("shelf.90", "shelf.128")
        if is_remembered_after_grabbing(REFERENCE, name, *ON_SHELVES)
    ]
    assert remembered == ["shelf.128"]


def test_both_vocabularies_store_the_same() -> None:
    assert virtualhome_quirks.SET_ORDER_VOCABULARY.predicates == VOCABULARY.predicates
    assert virtualhome_quirks.SET_ORDER_VOCABULARY.unary_slots == VOCABULARY.unary_slots
    assert virtualhome_quirks.SET_ORDER_VOCABULARY.binary_slots == VOCABULARY.binary_slots
    assert REFERENCE.vocabulary is virtualhome_quirks.SET_ORDER_VOCABULARY


def test_relevant_objects_are_in_the_order_of_a_hash_table(virtualhome_tasks: VirtualHomeTasks) -> None:
    reordered = 0
    for task in virtualhome_tasks.values():
        in_reference = virtualhome_quirks.list_task_objects_in_published_order(task)
        assert sorted(in_reference) == list(task.relevant)
        reordered += in_reference != task.relevant
    assert reordered > 100
