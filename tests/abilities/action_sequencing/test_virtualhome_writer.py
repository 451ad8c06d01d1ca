from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.virtualhome import flat
from eai.abilities.action_sequencing import virtualhome_answer
from eai.abilities.action_sequencing.plan import WrittenPlan
from eai.abilities.action_sequencing.virtualhome_writer import join_steps, write_steps
from eai.benchmarks.reference import virtualhome_plans as virtualhome_reference
from eai.world.execution import Action

SCENE = flat.scene()
ACTIONS = st.builds(
    Action,
    st.sampled_from(["WALK", "PUTBACK", "STANDUP"]),
    st.lists(st.sampled_from(range(len(SCENE.objects))), max_size=2).map(tuple),
)


@pytest.mark.parametrize(
    ("plan", "text"),
    [
        ([], "{}"),
        (["WALK fridge.10"], '{"WALK": ["fridge", "10"]}'),
        (["STANDUP", "STANDUP"], '{"STANDUP": [ ], "STANDUP": [ ]}'),
        (["PUTIN cup.13 fridge.10"], '{"PUTIN": ["cup", "13", "fridge", "10"]}'),
    ],
)
def test_a_plan_is_written_with_names_and_ids(plan: list[str], text: str) -> None:
    actions = [flat.action(step, SCENE) for step in plan]
    assert join_steps(write_steps(actions, SCENE)) == text


@given(st.lists(ACTIONS, min_size=1, max_size=5))
def test_both_protocols_read_what_is_written(plan: list[Action]) -> None:
    text = join_steps(write_steps(plan, SCENE))
    strict, reference = virtualhome_answer.read_plan(text), virtualhome_reference.read_plan(text)
    assert isinstance(strict, WrittenPlan)
    assert strict == reference
    assert [step.action for step in strict.steps] == [action.operator for action in plan]
    assert [len(step.arguments) for step in strict.steps] == [2 * len(a.arguments) for a in plan]
