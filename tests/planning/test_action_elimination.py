from __future__ import annotations

from eai.planning.action_elimination import without_needless_actions
from planning.test_successor_generator import INDEX, START, SUCCESSORS, action, walk


def test_what_is_not_needed_is_left_out_with_what_hangs_on_it() -> None:
    end = walk(
        action("LIFT", "red"),
        action("DROP", "red"),
        action("GO", "shed"),
        action("LIFT", "blue"),
        action("PRESS", "lamp"),
    )
    lit = without_needless_actions(SUCCESSORS, START, end, lambda node: node.state.has("lit", INDEX["lamp"]))
    assert lit.plan() == [action("GO", "shed"), action("PRESS", "lamp")]
    assert without_needless_actions(SUCCESSORS, START, end, lambda node: True).plan() == []
