from __future__ import annotations

from functools import reduce
from operator import or_

from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks


def test_relations_know_their_sources_and_targets(virtualhome_tasks: VirtualHomeTasks) -> None:
    """They are counted while states are built, edges coming and going, and not gathered afterwards."""
    states = [
        state
        for task in virtualhome_tasks.values()
        for state in (task.initial, task.annotated_final)
        if state is not None
    ]
    assert len(states) == 2 * len(virtualhome_tasks)
    for state in states:
        for relation in state.binary:
            matrix = relation._base
            assert matrix.sources == reduce(or_, matrix.columns, 0)
            assert matrix.targets == reduce(or_, matrix.rows, 0)
            assert len(matrix.rows) == len(matrix.columns) == len(state.scene.objects)
