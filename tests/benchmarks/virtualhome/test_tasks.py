from __future__ import annotations

from functools import reduce
from operator import or_

from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks


def test_a_relation_has_the_masks_of_its_sources_and_targets(virtualhome_tasks: VirtualHomeTasks) -> None:
    """Building a state updates the masks with every added or removed edge."""
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
