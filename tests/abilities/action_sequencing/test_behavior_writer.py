from __future__ import annotations

from benchmarks.behavior.kitchen import actions, make_task
from eai.abilities.action_sequencing.behavior import ActionSequencing, Rejected
from eai.abilities.action_sequencing.behavior_writer import join_steps, write_steps
from eai.abilities.action_sequencing.plan import Unreadable
from eai.abilities.protocol import Protocol


def test_both_protocols_read_what_is_written() -> None:
    task = make_task()
    plan = actions(
        task.initial, "OPEN fridge_1", "RIGHT_GRASP peach_1", "RIGHT_PLACE_NEXTTO_ONTOP rag_1 table_1"
    )
    text = join_steps(write_steps(plan, task.scene))
    for protocol in Protocol:
        scorer = ActionSequencing(task, protocol)
        written = scorer.read(text)
        assert not isinstance(written, Unreadable)
        resolved = scorer.resolve(written)
        assert not isinstance(resolved, Rejected)
        assert (resolved, written.repairs) == (plan, ())
