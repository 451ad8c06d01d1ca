"""Draw diagrams of scenes as SVG and PNG. Equal diagrams give equal bytes.

Each object is a rectangle, with the facts about it as text and with the objects in or on it as smaller
rectangles. Rectangles within one rectangle never overlap, and texts stay in their rectangle. All texts use
one monospaced font, so the number of characters gives the width of a text.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape, quoteattr

from eai.base.errors import require_extra
from eai.extensions.scenes.tiles import BOTH_WAYS, ONE_WAY
from eai.studies.report.explorer import ObjectRectangle, ObjectRole

if TYPE_CHECKING:
    from PIL.Image import Image

FONT = "DejaVuSansMono"
_FAMILY = "'DejaVu Sans Mono', Menlo, Consolas, monospace"

WIDTH = 1024
NAME_SIZE, TEXT_SIZE = 14, 12
_PAD, _GAP, _LEAD = 8, 8, 17
_TEXT_COLUMNS = 34
"""Width of the lines in an object's rectangle, in characters.

A rectangle is wider if its name or its nested rectangles need more space.
"""

_INK = "#1a1a1a"
_FILLS: Mapping[ObjectRole, str] = {"agent": "#fff3d6", "object": "#ffffff", "other": "#f0f0f0"}
_STROKES: Mapping[ObjectRole, str] = {"agent": "#b36b00", "object": "#20456e", "other": "#8a8a8a"}
_LINES: Mapping[ObjectRole, int] = {"agent": 2, "object": 1, "other": 1}
_ZONE_FILL, _ZONE_STROKE = "#e8eff7", "#9db4cd"
_MARK_FILL, _MARK_STROKE = "#dcefdc", "#3f7d3f"
_EMPTY = "(empty)"


@dataclass(frozen=True, slots=True)
class _Rectangle:
    """A rectangle, in pixels from the top left corner of the picture; colours as ``#rrggbb``."""

    x: int
    y: int
    width: int
    height: int
    fill: str
    stroke: str
    radius: int = 0
    line: int = 1


@dataclass(frozen=True, slots=True)
class _DrawnText:
    """A line of text. Its location is the top left corner of the text."""

    x: int
    y: int
    text: str
    size: int
    colour: str
    bold: bool = False


_Shape = _Rectangle | _DrawnText


@dataclass(frozen=True, slots=True)
class Drawing:
    """A drawing: shapes located from its top left corner. Later shapes cover earlier shapes."""

    width: int
    height: int
    shapes: Sequence[_Shape]


def text_width(text: str, size: int) -> int:
    """Return the width of a text in pixels."""
    return len(text) * round(0.602 * size)


def to_svg(drawing: Drawing) -> str:
    """Return the drawing as SVG."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{drawing.width}" height="{drawing.height}" '
        f'viewBox="0 0 {drawing.width} {drawing.height}" font-family={quoteattr(_FAMILY)}>'
    )
    white = f'<rect width="{drawing.width}" height="{drawing.height}" fill="#ffffff"/>'
    return "\n".join([head, white, *map(_to_svg_element, drawing.shapes), "</svg>", ""])


def _to_svg_element(shape: _Shape) -> str:
    if isinstance(shape, _Rectangle):
        return (
            f'<rect x="{shape.x}" y="{shape.y}" width="{shape.width}" height="{shape.height}" '
            f'rx="{shape.radius}" fill="{shape.fill}" stroke="{shape.stroke}" stroke-width="{shape.line}"/>'
        )
    weight = ' font-weight="bold"' if shape.bold else ""
    return (
        f'<text x="{shape.x}" y="{shape.y + round(0.8 * shape.size)}" font-size="{shape.size}"{weight} '
        f'textLength="{text_width(shape.text, shape.size)}" lengthAdjust="spacingAndGlyphs" '
        f'fill="{shape.colour}">{escape(shape.text)}</text>'
    )


def to_png(drawing: Drawing) -> bytes:
    """Return the drawing as PNG.

    Raises:
        EaiError: matplotlib, which contains the font and installs Pillow, is not installed.
    """
    file = io.BytesIO()
    to_pillow_image(drawing).save(file, "PNG", optimize=False)
    return file.getvalue()


def to_pillow_image(drawing: Drawing) -> Image:
    """Return the drawing as an RGB image of the library Pillow.

    Raises:
        EaiError: see `to_png`.
    """
    with require_extra("plots", "pictures as PNG need"):
        import matplotlib as mpl
        from PIL import Image, ImageDraw, ImageFont
    folder = Path(mpl.get_data_path()) / "fonts" / "ttf"

    @cache
    def load_font(size: int, *, bold: bool) -> Any:
        name = f"{FONT}{'-Bold' if bold else ''}.ttf"
        return ImageFont.truetype(str(folder / name), size, layout_engine=ImageFont.Layout.BASIC)

    image = Image.new("RGB", (drawing.width, drawing.height), "#ffffff")
    canvas = ImageDraw.Draw(image)
    for shape in drawing.shapes:
        if isinstance(shape, _Rectangle):
            corners = (shape.x, shape.y, shape.x + shape.width - 1, shape.y + shape.height - 1)
            canvas.rounded_rectangle(corners, shape.radius, shape.fill, shape.stroke, shape.line)
        else:
            named = load_font(shape.size, bold=shape.bold)
            canvas.text((shape.x, shape.y), shape.text, shape.colour, named)
    return image


def draw_object_rectangles(tiles: Sequence[ObjectRectangle]) -> Drawing:
    """Draw objects as rectangles, with a legend below them.

    The drawing is as high as necessary, and `WIDTH` pixels wide. High piles and long names make it wider.
    """
    inner = WIDTH - 2 * _GAP
    boxes = [_draw_object_rectangle(tile, inner) for tile in tiles]
    scene, legend = _pack_boxes(boxes, inner), _draw_legend(inner)
    shapes = [
        *_move_shapes(scene.shapes, _GAP, _GAP),
        *_move_shapes(legend.shapes, _GAP, scene.height + 2 * _GAP),
    ]
    return Drawing(max(WIDTH, scene.width + 2 * _GAP), scene.height + legend.height + 3 * _GAP, shapes)


def _draw_object_rectangle(tile: ObjectRectangle, max_width: int) -> Drawing:
    """Draw the rectangle of an object and those nested in it, at most ``max_width`` pixels wide."""
    inner = max_width - 2 * _PAD
    zones = _arrange_in_rows(
        [_draw_objects_in_relation(label, within, inner) for label, within in tile.zones.items()], inner
    )
    named, letter = text_width(tile.name, NAME_SIZE), text_width(" ", TEXT_SIZE)
    columns = max(_TEXT_COLUMNS, max(named, zones.width) // letter)
    lines = [part for line in tile.lines for part in wrap(line, columns, subsequent_indent="  ")]
    marks = _arrange_in_rows([_draw_text_badge(text) for text in tile.marks], columns * letter, gap=4)
    width = max([named, marks.width, zones.width, *[text_width(line, TEXT_SIZE) for line in lines]])
    shapes: list[_Shape] = [_DrawnText(_PAD, _PAD, tile.name, NAME_SIZE, _INK, bold=True)]
    y = _PAD + NAME_SIZE + 6
    if marks.shapes:
        shapes += _move_shapes(marks.shapes, _PAD, y)
        y += marks.height + 5
    for line in lines:
        shapes.append(_DrawnText(_PAD, y, line, TEXT_SIZE, _INK))
        y += _LEAD
    if zones.shapes:
        shapes += _move_shapes(zones.shapes, _PAD, y)
        y += zones.height
    height, width = y + _PAD, width + 2 * _PAD
    frame = _Rectangle(0, 0, width, height, _FILLS[tile.kind], _STROKES[tile.kind], 6, _LINES[tile.kind])
    return Drawing(width, height, [frame, *shapes])


def _draw_objects_in_relation(
    relation_label: str, tiles: Sequence[ObjectRectangle], max_width: int
) -> Drawing:
    """Draw a frame with the rectangles of all objects that have one relation to the surrounding object."""
    top = _PAD + TEXT_SIZE + 5
    content = _pack_boxes(
        [_draw_object_rectangle(tile, max_width - 2 * _PAD) for tile in tiles], max_width - 2 * _PAD
    )
    shapes: list[_Shape] = [
        _DrawnText(
            _PAD,
            _PAD - 2,
            relation_label if tiles else f"{relation_label} {_EMPTY}",
            TEXT_SIZE,
            _STROKES["object"],
        )
    ]
    width = max(content.width, text_width(f"{relation_label} {_EMPTY}", TEXT_SIZE)) + 2 * _PAD
    height = top + content.height + (_PAD if tiles else 0)
    frame = _Rectangle(0, 0, width, height, _ZONE_FILL, _ZONE_STROKE)
    return Drawing(width, height, [frame, *shapes, *_move_shapes(content.shapes, _PAD, top)])


def _draw_text_badge(text: str) -> Drawing:
    width, height = text_width(text, TEXT_SIZE) + 10, TEXT_SIZE + 6
    frame = _Rectangle(0, 0, width, height, _MARK_FILL, _MARK_STROKE, 8)
    return Drawing(width, height, [frame, _DrawnText(5, 3, text, TEXT_SIZE, _INK)])


def _pack_boxes(boxes: Sequence[Drawing], max_width: int) -> Drawing:
    """Arrange boxes in rows. The highest boxes come first, which leaves little space empty."""
    return _arrange_in_rows(sorted(boxes, key=lambda box: -box.height), max_width)


def _arrange_in_rows(boxes: Sequence[Drawing], max_width: int, gap: int = _GAP) -> Drawing:
    """Arrange boxes side by side. A box that does not fit into its row begins the next row."""
    shapes: list[_Shape] = []
    x = y = width = row = 0
    for box in boxes:
        if x and x + box.width > max_width:
            x, y, row = 0, y + row + gap, 0
        shapes += _move_shapes(box.shapes, x, y)
        x += box.width + gap
        width, row = max(width, x - gap), max(row, box.height)
    return Drawing(width, y + row, shapes)


def _draw_legend(max_width: int) -> Drawing:
    samples = [
        (_draw_legend_colour("object"), "object"),
        (_draw_legend_colour("agent"), "the one who acts"),
        (_draw_legend_colour("other"), "another object"),
        (_draw_text_badge("state"), "holds of it"),
        (_draw_frame(_ZONE_FILL, _ZONE_STROKE), "what lies here is in this relation to the object around it"),
        (_draw_text(f"relation {ONE_WAY} x:"), "it is in this relation to x"),
        (_draw_text(f"relation {BOTH_WAYS} x:"), "so it is, and x to it"),
        (_draw_text("Nothing else"), "holds of these objects."),
    ]
    return _arrange_in_rows(
        [_arrange_in_rows([sample, _draw_text(text)], max_width, 7) for sample, text in samples],
        max_width,
        18,
    )


def _draw_legend_colour(owner: ObjectRole) -> Drawing:
    return _draw_frame(_FILLS[owner], _STROKES[owner], 4, _LINES[owner])


def _draw_frame(fill: str, stroke: str, radius: int = 0, line: int = 1) -> Drawing:
    return Drawing(22, 18, [_Rectangle(0, 0, 22, 18, fill, stroke, radius, line)])


def _draw_text(text: str) -> Drawing:
    return Drawing(text_width(text, TEXT_SIZE), 18, [_DrawnText(0, 3, text, TEXT_SIZE, _INK)])


def _move_shapes(shapes: Sequence[_Shape], x: int, y: int) -> Iterator[_Shape]:
    for shape in shapes:
        yield replace(shape, x=shape.x + x, y=shape.y + y)
