"""Layout: where tiles lie in a picture. Boxes within one box never overlap, and texts stay in their box."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from textwrap import wrap

from eai.studies.perception.drawing import Drawing, Rectangle, Text, text_width
from eai.studies.perception.tiles import BOTH_WAYS, ONE_WAY, Kind, Tile

WIDTH = 1024
NAME_SIZE, TEXT_SIZE = 14, 12
_PAD, _GAP, _LEAD = 8, 8, 17
_TEXT_COLUMNS = 34
"""How wide the lines of a tile are, in characters, unless its name is wider."""

_INK = "#1a1a1a"
_FILLS = {Kind.AGENT: "#fff3d6", Kind.OBJECT: "#ffffff", Kind.OTHER: "#f0f0f0"}
_STROKES = {Kind.AGENT: "#b36b00", Kind.OBJECT: "#20456e", Kind.OTHER: "#8a8a8a"}
_LINES = {Kind.AGENT: 2, Kind.OBJECT: 1, Kind.OTHER: 1}
_ZONE_FILL, _ZONE_STROKE = "#e8eff7", "#9db4cd"
_MARK_FILL, _MARK_STROKE = "#dcefdc", "#3f7d3f"
_EMPTY = "(empty)"

Shape = Rectangle | Text


@dataclass(frozen=True, slots=True)
class _Box:
    """Shapes with the size of the rectangle around them, from its top left corner."""

    width: int
    height: int
    shapes: Sequence[Shape]


def draw(tiles: Sequence[Tile]) -> Drawing:
    """The picture of tiles, with a legend below: `WIDTH` wide, as high as it takes."""
    inner = WIDTH - 2 * _GAP
    boxes = [_box(tile, inner) for tile in tiles]
    scene, legend = _packed(boxes, inner), _legend(inner)
    shapes = [*_moved(scene.shapes, _GAP, _GAP), *_moved(legend.shapes, _GAP, scene.height + 2 * _GAP)]
    return Drawing(WIDTH, scene.height + legend.height + 3 * _GAP, shapes)


def _box(tile: Tile, most: int) -> _Box:
    """The tile at its place at the top left corner, no wider than there is room."""
    inner = most - 2 * _PAD
    zones = _flow([_zone(label, within, inner) for label, within in tile.zones.items()], inner)
    named, letter = text_width(tile.name, NAME_SIZE), text_width(" ", TEXT_SIZE)
    columns = max(_TEXT_COLUMNS, max(named, zones.width) // letter)
    lines = [part for line in tile.lines for part in wrap(line, columns, subsequent_indent="  ")]
    marks = _flow([_mark(text) for text in tile.marks], columns * letter, gap=4)
    width = max([named, marks.width, zones.width, *[text_width(line, TEXT_SIZE) for line in lines]])
    shapes: list[Shape] = [Text(_PAD, _PAD, tile.name, NAME_SIZE, _INK, bold=True)]
    y = _PAD + NAME_SIZE + 6
    if marks.shapes:
        shapes += _moved(marks.shapes, _PAD, y)
        y += marks.height + 5
    for line in lines:
        shapes.append(Text(_PAD, y, line, TEXT_SIZE, _INK))
        y += _LEAD
    if zones.shapes:
        shapes += _moved(zones.shapes, _PAD, y)
        y += zones.height
    height, width = y + _PAD, width + 2 * _PAD
    frame = Rectangle(0, 0, width, height, _FILLS[tile.kind], _STROKES[tile.kind], 6, _LINES[tile.kind])
    return _Box(width, height, [frame, *shapes])


def _zone(label: str, within: Sequence[Tile], most: int) -> _Box:
    """What stands in one relation to the thing whose tile it lies in."""
    top = _PAD + TEXT_SIZE + 5
    content = _packed([_box(tile, most - 2 * _PAD) for tile in within], most - 2 * _PAD)
    shapes: list[Shape] = [
        Text(_PAD, _PAD - 2, label if within else f"{label} {_EMPTY}", TEXT_SIZE, _STROKES[Kind.OBJECT])
    ]
    width = max(content.width, text_width(f"{label} {_EMPTY}", TEXT_SIZE)) + 2 * _PAD
    height = top + content.height + (_PAD if within else 0)
    frame = Rectangle(0, 0, width, height, _ZONE_FILL, _ZONE_STROKE)
    return _Box(width, height, [frame, *shapes, *_moved(content.shapes, _PAD, top)])


def _mark(text: str) -> _Box:
    width, height = text_width(text, TEXT_SIZE) + 10, TEXT_SIZE + 6
    frame = Rectangle(0, 0, width, height, _MARK_FILL, _MARK_STROKE, 8)
    return _Box(width, height, [frame, Text(5, 3, text, TEXT_SIZE, _INK)])


def _packed(boxes: Sequence[_Box], most: int) -> _Box:
    """Boxes row by row, the highest first, so that little is left empty."""
    return _flow(sorted(boxes, key=lambda box: -box.height), most)


def _flow(boxes: Sequence[_Box], most: int, gap: int = _GAP) -> _Box:
    """Boxes side by side, row by row; one that is too wide for its row begins the next."""
    shapes: list[Shape] = []
    x = y = width = row = 0
    for box in boxes:
        if x and x + box.width > most:
            x, y, row = 0, y + row + gap, 0
        shapes += _moved(box.shapes, x, y)
        x += box.width + gap
        width, row = max(width, x - gap), max(row, box.height)
    return _Box(width, y + row, shapes)


def _legend(most: int) -> _Box:
    """What the parts of a picture mean."""
    samples = [
        (_swatch(Kind.OBJECT), "object"),
        (_swatch(Kind.AGENT), "the one who acts"),
        (_swatch(Kind.OTHER), "another object"),
        (_mark("state"), "holds of it"),
        (_frame(_ZONE_FILL, _ZONE_STROKE), "what lies here is in this relation to the object around it"),
        (_words(f"relation {ONE_WAY} x:"), "it is in this relation to x"),
        (_words(f"relation {BOTH_WAYS} x:"), "so it is, and x to it"),
        (_words("Nothing else"), "holds of these objects."),
    ]
    return _flow([_flow([sample, _words(text)], most, 7) for sample, text in samples], most, 18)


def _swatch(kind: Kind) -> _Box:
    return _frame(_FILLS[kind], _STROKES[kind], 4, _LINES[kind])


def _frame(fill: str, stroke: str, radius: int = 0, line: int = 1) -> _Box:
    return _Box(22, 18, [Rectangle(0, 0, 22, 18, fill, stroke, radius, line)])


def _words(text: str) -> _Box:
    return _Box(text_width(text, TEXT_SIZE), 18, [Text(0, 3, text, TEXT_SIZE, _INK)] if text else [])


def _moved(shapes: Sequence[Shape], x: int, y: int) -> Iterator[Shape]:
    for shape in shapes:
        yield replace(shape, x=shape.x + x, y=shape.y + y)
