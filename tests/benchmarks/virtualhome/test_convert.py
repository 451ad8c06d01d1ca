from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.graphs import ORDERED, PlainGraph, build_final_graph, build_initial_graph
from benchmarks.synthetic import PROGRAMS, SCENE, TASKS, MadeTask, Triple, bundle, files, graph, node
from eai.base.errors import DataError
from eai.base.store import DataPackStore, ignore_progress
from eai.benchmarks.virtualhome.convert import convert_tasks
from eai.benchmarks.virtualhome.records import (
    VirtualHomeRecords,
)


def convert(tasks: tuple[MadeTask, ...], folder: Path) -> VirtualHomeRecords:
    members = convert_tasks(bundle(files(tasks)), ignore_progress)
    return VirtualHomeRecords.from_pack(DataPackStore(folder).write_pack("virtualhome", {}, members))


@pytest.fixture
def tasks(tmp_path: Path) -> VirtualHomeRecords:
    return convert(TASKS, tmp_path)


def expected_targets(values: dict[str, Any]) -> dict[tuple[int, str], list[int]]:
    groups: dict[tuple[int, str], dict[int, None]] = {}
    for edge in values["edges"]:
        groups.setdefault((edge["from_id"], edge["relation_type"]), {})[edge["to_id"]] = None
    return {key: list(ids) if key[1] in ORDERED else sorted(ids) for key, ids in groups.items()}


def assert_objects(graph: PlainGraph, values: dict[str, Any]) -> None:
    last = {entry["id"]: entry for entry in values["nodes"]}
    assert graph.objects.keys() == last.keys()
    for identifier, record in graph.objects.items():
        expected = last[identifier]
        assert (record.id, record.class_name, record.category) == (
            identifier,
            expected["class_name"],
            expected["category"],
        )
        assert record.properties == tuple(sorted(set(expected["properties"])))
        assert record.states == tuple(sorted(set(expected["states"])))


def test_tasks_come_in_the_order_of_the_annotations(tasks: VirtualHomeRecords) -> None:
    assert list(tasks) == ["1_1", "2_1", "3_1"]
    assert [task.title for task in tasks.values()] == ["Turn on light", "Turn on light", "Put cup"]
    assert tasks["1_1"] is tasks["1_1"]
    with pytest.raises(KeyError):
        tasks["4_1"]


def test_scripts_and_goals_are_stored_as_annotated(tasks: VirtualHomeRecords) -> None:
    cup, sofa = ("cup", 1000), ("sofa", 90)
    assert tasks["3_1"].script == (("GRAB", (cup,)), ("PUTBACK", (cup, sofa)))
    assert tasks["3_1"].description == "Put it on the sofa."
    assert tasks["3_1"].edge_goals == ((1000, "ON", 90), (1000, "ON", 7))
    assert tasks["1_1"].node_goals == ((7, "lamp", "ON"),)
    assert tasks["1_1"].action_goals == (("LOOKAT", "WATCH"),)
    assert (tasks["1_1"].tl_goal, tasks["2_1"].tl_goal) == ("ON(lamp.7)", None)
    assert tasks["2_1"].script == (("STANDUP", ()),)


@pytest.mark.parametrize("made", TASKS, ids=lambda made: made.id)
def test_graphs_can_be_restored_from_their_differences(tasks: VirtualHomeRecords, made: MadeTask) -> None:
    graph_read = build_initial_graph(tasks.base, tasks[made.id])
    assert_objects(graph_read, made.initial)
    assert graph_read.targets() == expected_targets(made.initial)
    graph_read = build_final_graph(tasks.base, tasks[made.id])
    assert_objects(graph_read, made.final)
    assert {key: set(ids) for key, ids in graph_read.targets().items()} == {
        key: set(ids) for key, ids in expected_targets(made.final).items()
    }


def test_relevant_objects_have_their_order_of_occurrence(tasks: VirtualHomeRecords) -> None:
    assert tasks["1_1"].relevant_from_nodes == (7,)
    assert tasks["1_1"].relevant_from_edges == (65, 90)
    assert tasks["2_1"].relevant_from_nodes == tasks["2_1"].relevant_from_edges == ()
    assert tasks["3_1"].relevant_from_edges == (1000, 1, 90)


def test_conversion_reports_the_number_of_converted_tasks() -> None:
    steps: list[tuple[object, ...]] = []
    convert_tasks(bundle(files()), lambda stage, _, *counts: steps.append((stage, *counts)))
    assert steps == [("converting", done, 3) for done in range(4)]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (b"Turn on light", b"Turn off light", "title 'Turn off light'"),
        (b"[WALK]", b"WALK", "'WALK <lamp> .* is not a step"),
    ],
)
def test_a_script_with_an_unexpected_form_is_an_error(old: bytes, new: bytes, reason: str) -> None:
    contents = files()
    path = f"{PROGRAMS}executable_programs/{SCENE}1_1.txt"
    contents[path] = contents[path].replace(old, new)
    with pytest.raises(DataError, match=reason):
        convert_tasks(bundle(contents), ignore_progress)


IDS = st.integers(1, 4)
EDGES = st.lists(st.tuples(IDS, st.sampled_from(["ON", "INSIDE", "CLOSE"]), IDS), max_size=12)
STATES = st.lists(st.sampled_from(["ON", "OFF"]), min_size=4, max_size=4)


def random_graph(edges: list[Triple], states: list[str], size: int) -> dict[str, Any]:
    nodes = [node(number + 1, f"class{number}", [state]) for number, state in enumerate(states[:size])]
    return graph(nodes, [edge for edge in edges if max(edge[0], edge[2]) <= size])


@given(st.lists(st.tuples(EDGES, STATES, st.integers(1, 4), EDGES, STATES), min_size=1, max_size=4))
def test_any_graphs_can_be_restored_from_their_differences(
    drawn: list[tuple[list[Triple], list[str], int, list[Triple], list[str]]],
) -> None:
    made = tuple(
        MadeTask(
            str(number),
            "Title",
            "Title\nText\n",
            [],
            [],
            None,
            random_graph(before, states, size),
            random_graph(after, final_states, size),
        )
        for number, (before, states, size, after, final_states) in enumerate(drawn)
    )
    with TemporaryDirectory() as folder:
        tasks = convert(made, Path(folder))
    for made_task in made:
        first = build_initial_graph(tasks.base, tasks[made_task.id])
        last = build_final_graph(tasks.base, tasks[made_task.id])
        assert_objects(first, made_task.initial)
        assert_objects(last, made_task.final)
        assert first.targets() == expected_targets(made_task.initial)
        assert last.targets().keys() == expected_targets(made_task.final).keys()
        assert len(last.edges) == len({tuple(edge.values()) for edge in made_task.final["edges"]})
