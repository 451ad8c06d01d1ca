from __future__ import annotations

import pytest

from benchmarks.test_export import draw_tasks
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.extensions.reference.virtualhome_quirks import make_domain_with_all_quirks
from eai.pddl.export import export_domain_and_problem
from eai.world.domain import Domain
from world.test_conformance import test_virtualhome_conforms
from world.test_effect import test_the_engine_equals_plain_sets_in_virtualhome

SHARED = (test_virtualhome_conforms, test_the_engine_equals_plain_sets_in_virtualhome)
"""Tests of the paper's rules, which are run again with the fixture `domain` below."""


@pytest.fixture
def domain() -> Domain:
    return make_domain_with_all_quirks()


def test_what_is_not_exported_exactly_is_named(virtualhome_tasks: VirtualHomeTasks) -> None:
    (task,) = draw_tasks(virtualhome_tasks, 1)
    reason = "its formula leaves open which of several objects is the first"
    assert export_domain_and_problem(make_domain_with_all_quirks(), task.initial, ()).unsupported == tuple(
        f"{name}: {reason}" for name in ("room_of", "lies_on", "lies_in", "lies_next_to")
    )
