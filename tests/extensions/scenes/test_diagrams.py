"""Pictures: nothing overlaps, all that holds can be read in them, and reading it back is free of error."""

from __future__ import annotations

from itertools import combinations
from typing import get_args
from xml.etree import ElementTree

import pytest

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.extensions.scenes.diagrams import draw_scene, make_words_for_picture_labels
from eai.extensions.scenes.drawing import (
    WIDTH,
    Drawing,
    _DrawnText,
    _Rectangle,
    draw_object_rectangles,
    text_width,
    to_png,
    to_svg,
)
from eai.extensions.scenes.tiles import make_object_rectangles
from eai.studies.perception.choice import Clutter
from eai.studies.perception.errors import find_perception_errors
from eai.studies.perception.scene_graph import SceneGraph
from eai.studies.report.explorer import ObjectRectangle
from eai.tasks.source import Source
from extensions.scenes.tile_facts import told_by
from studies.perception.kitchen import TRUTH, WORDS, fact, kitchen_task, seen


def within(inner: _Rectangle, outer: _Rectangle) -> bool:
    return (
        outer.x <= inner.x
        and outer.y <= inner.y
        and inner.x + inner.width <= outer.x + outer.width
        and inner.y + inner.height <= outer.y + outer.height
    )


def apart(one: _Rectangle, other: _Rectangle) -> bool:
    return (
        one.x + one.width <= other.x
        or other.x + other.width <= one.x
        or one.y + one.height <= other.y
        or other.y + other.height <= one.y
    )


def area(text: _DrawnText) -> _Rectangle:
    return _Rectangle(text.x, text.y, text_width(text.text, text.size), text.size, "", "")


def check(picture: tuple[Drawing, SceneGraph]) -> None:
    """Boxes are apart or nested, and texts cross no edge and each other nowhere."""
    drawing, _ = picture
    boxes = [shape for shape in drawing.shapes if isinstance(shape, _Rectangle)]
    texts = [area(shape) for shape in drawing.shapes if isinstance(shape, _DrawnText)]
    page = _Rectangle(0, 0, drawing.width, drawing.height, "", "")
    assert drawing.width == WIDTH
    assert all(within(each, page) for each in (*boxes, *texts))
    assert all(apart(a, b) or within(a, b) or within(b, a) for a, b in combinations(boxes, 2))
    assert all(apart(text, box) or within(text, box) for text in texts for box in boxes)
    assert all(apart(a, b) for a, b in combinations(texts, 2))


def test_tiles_say_all_and_nothing_else() -> None:
    graph = SceneGraph(TRUTH.objects, (*TRUTH.facts, *map(fact, ("holds robot lamp_2", "on cup_1 table_1"))))
    tiles = make_object_rectangles(graph, WORDS, "robot")
    assert set().union(*(told_by(tile, "robot") for tile in tiles)) == {*graph.facts}
    robot = tiles[0]
    assert (robot.name, robot.kind) == ("robot", "agent")
    assert [tile.name for tile in robot.zones["holds"]] == ["lamp_2"]
    (table,) = [tile for tile in tiles if tile.name == "table_1"]
    (box,) = table.zones["on"]
    assert [tile.name for tile in box.zones["in"]] == ["cup_1"]  # in the innermost; the other is a line


@pytest.mark.parametrize(
    "circle",
    [
        ("in cup_1 box_1", "in box_1 cup_1"),
        ("on cup_1 cup_1",),
        ("holds robot cup_1", "on robot box_1", "in box_1 cup_1"),
        ("holds robot robot",),
    ],
)
def test_a_circle_is_shown_as_lines(circle: tuple[str, ...]) -> None:
    graph = seen(*circle)
    tiles = make_object_rectangles(graph, WORDS, "robot")
    assert set().union(*(told_by(tile, "robot") for tile in tiles)) == {*graph.facts}


def test_facts_about_no_object_or_three_objects_are_shown() -> None:
    graph = seen("free", "between cup_1 box_1 table_1", "on cup_1 box_1")
    tiles = make_object_rectangles(graph, WORDS, "robot")
    assert set().union(*(told_by(tile, "robot") for tile in tiles)) == {*graph.facts}


def test_a_picture_is_as_wide_as_a_high_pile_needs() -> None:
    pile = ObjectRectangle("object_0", "object")
    for number in range(1, 30):
        pile = ObjectRectangle(f"object_{number}", "object", zones={"on": [pile]})
    drawing = draw_object_rectangles([pile, ObjectRectangle("a" * 200, "object")])
    page = _Rectangle(0, 0, drawing.width, drawing.height, "", "")
    assert drawing.width > WIDTH
    assert all(within(shape, page) for shape in drawing.shapes if isinstance(shape, _Rectangle))


@pytest.mark.parametrize("clutter", get_args(Clutter))
@pytest.mark.parametrize(("name", "every"), [("behavior", 5), ("virtualhome", 17)])
def test_pictures_of_households(name: str, every: int, clutter: Clutter, data_store: DataPackStore) -> None:
    benchmark = find_benchmark(name)
    tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source(data_store))
    words = make_words_for_picture_labels(benchmark)
    for task_id in list(tasks)[::every]:
        task = tasks[task_id]
        picture = draw_scene(task, words, clutter)
        check(picture)
        perceived = find_perception_errors(task, words, picture[1])
        wrong = (perceived.missing, perceived.misplaced, perceived.unnecessary, perceived.invented)
        assert (wrong, perceived.unseen) == ((0, 0, 0, 0), 0)
        assert {*words.make_true_graph(task).facts} <= {*picture[1].facts}


def test_clutter_adds_objects() -> None:
    sizes = [
        len(draw_scene(kitchen_task(), WORDS, clutter, objects=[1])[1].objects)
        for clutter in get_args(Clutter)
    ]
    assert sizes == [1, 2, 4]


def test_equal_states_give_equal_bytes() -> None:
    one, other = (draw_scene(kitchen_task(), WORDS)[0] for _ in range(2))
    assert to_svg(one) == to_svg(other)
    assert to_png(one) == to_png(other)
    assert to_png(one).startswith(b"\x89PNG")
    assert ElementTree.fromstring(to_svg(one)).get("width") == str(WIDTH)  # noqa: S314 - our own
