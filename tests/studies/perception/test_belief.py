from __future__ import annotations

import pytest

from eai.planning.planner import Planner
from eai.studies.perception.belief import UNSEEN, replace_scene_by_scene_graph
from eai.studies.perception.scene_graph import SceneGraph
from eai.tasks.planning import find_plan
from studies.perception.kitchen import DOMAIN, KITCHEN, TRUTH, WORDS, fact, kitchen_task, seen

ALL = ("in cup_1 box_1", "on box_1 table_1", "lit lamp_1")


def plan(graph: SceneGraph) -> list[str]:
    """Return a plan for the perceived scene."""
    task = replace_scene_by_scene_graph(kitchen_task(), WORDS, graph)
    found = find_plan(task, Planner(DOMAIN))
    return [
        " ".join([each.operator, *(task.scene.objects[i].name for i in each.arguments)])
        for each in found.plan
    ]


def test_a_complete_scene_graph_leaves_the_task_unchanged() -> None:
    task = kitchen_task()
    assert replace_scene_by_scene_graph(task, WORDS, TRUTH) is task


@pytest.mark.parametrize(
    ("facts", "done"),
    [
        (ALL, ["TAKE cup_1", "PUT_ON cup_1 table_1", "LIGHT lamp_2"]),
        ((*ALL, "lit lamp_2"), ["TAKE cup_1", "PUT_ON cup_1 table_1"]),
        (("on cup_1 table_1", *ALL[1:]), ["LIGHT lamp_2"]),
        (ALL[:2], ["TAKE cup_1", "PUT_ON cup_1 table_1", "LIGHT lamp_1", "LIGHT lamp_2"]),
    ],
)
def test_a_planner_plans_in_the_perceived_scene(facts: tuple[str, ...], done: list[str]) -> None:
    assert sorted(plan(seen(*facts))) == sorted(done)


def test_an_unseen_object_has_no_category_and_is_not_in_the_plan() -> None:
    objects = tuple(name for name in TRUTH.objects if name != "lamp_2")
    task = replace_scene_by_scene_graph(kitchen_task(), WORDS, seen(*ALL, objects=objects))
    assert task.scene.objects[5].category == UNSEEN
    assert 5 not in task.relevant
    assert plan(seen(*ALL, objects=objects)) == ["TAKE cup_1", "PUT_ON cup_1 table_1"]


def test_an_invented_object_has_the_category_of_the_object_with_a_similar_name() -> None:
    graph = seen(*ALL, "lit lamp_2", "on lamp_7 table_1", objects=(*TRUTH.objects, "lamp_7", "dragon"))
    task = replace_scene_by_scene_graph(kitchen_task(), WORDS, graph)
    new = [(thing.name, thing.category) for thing in task.scene.objects[6:]]
    assert new == [("lamp_7", "lamp"), ("dragon", "dragon")]
    assert task.initial.has("can_light", 6)
    assert not task.initial.has("can_light", 7)
    assert "LIGHT lamp_7" in plan(graph)


def test_a_perceived_circle_of_supports_is_left_out() -> None:
    task = replace_scene_by_scene_graph(kitchen_task(), WORDS, seen(*ALL, "in table_1 cup_1"))
    told = [str(each) for each in WORDS.make_true_graph(task).facts]
    assert "in(table_1, cup_1)" not in told
    assert {str(fact(each)) for each in ALL} == {*told}


def test_a_prompt_states_the_perceived_scene() -> None:
    task = replace_scene_by_scene_graph(
        kitchen_task(), WORDS, seen("lit lamp_2", objects=("cup_1", "lamp_2", "lamp_7"))
    )
    wording = KITCHEN.observation_wording()
    assert wording.describe_initial_state(task) == "lit(lamp_2)"
    assert wording.describe_objects(task).splitlines() == [
        "robot [robot]: -",
        "cup_1 [cup]: -",
        "lamp_2 [lamp]: can_light",
        "lamp_7 [lamp]: can_light",
        "",
        "The agent is robot.",
    ]
