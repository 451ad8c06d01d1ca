from __future__ import annotations

import pytest

from eai.studies.perception.scene_graph import SceneGraph, SceneGraphFact, read_scene_graph

ARITIES = {"in": 2, "lit": 1}
GRAPH = SceneGraph(("a", "b"), (SceneGraphFact("in", ("a", "b")), SceneGraphFact("lit", ("a",))))


def test_a_written_scene_graph_is_read_back() -> None:
    assert read_scene_graph(GRAPH.json_text, ARITIES) == GRAPH


@pytest.mark.parametrize(
    ("text", "facts", "ill_formed", "repairs"),
    [
        ('```json\n{"facts": [["lit", "a"], ["lit", "a"]]}\n```', ["lit(a)"], (), ("code_fence",)),
        ('I see: {"facts": [["lit", "a", "b"]]}', [], ('["lit", "a", "b"]',), ("prose",)),
        ('{"objects": [3], "facts": [["warm", "a"], [], 7, ["in", "a", 2]]}', [], 5, ()),
        (
            '{"objects": [{}], "facts": [{"in": ["a"]}, ["in", {}]]}',
            [],
            ("{}", '{"in": ["a"]}', '["in", {}]'),
            (),
        ),
        ('{"objects": ["a"], "facts": []}', [], (), ()),
    ],
)
def test_entries_of_a_scene_graph_that_are_no_facts_are_left_out(
    text: str, facts: list[str], ill_formed: tuple[str, ...] | int, repairs: tuple[str, ...]
) -> None:
    read = read_scene_graph(text, ARITIES)
    assert ([str(each) for each in read.facts], read.repairs) == (facts, repairs)
    assert ill_formed in (read.ill_formed, len(read.ill_formed))


@pytest.mark.parametrize(
    "text", ["", "a table and a cup", "[]", '{"facts": {"lit": "a"}}', '{"objects": ["a"]}']
)
def test_an_answer_without_facts_perceives_nothing(text: str) -> None:
    assert read_scene_graph(text, ARITIES).unreadable is not None


def test_the_names_of_a_scene_graph_include_those_in_facts() -> None:
    assert SceneGraph(("b",), (SceneGraphFact("in", ("a", "b")),)).mentioned_objects == ("b", "a")
