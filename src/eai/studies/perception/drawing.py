"""Drawings of rectangles and texts, as SVG and PNG; equal drawings give equal bytes.

All text is in one monospaced font, whose widths are known without measuring.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape, quoteattr

from eai.errors import EaiError, how_to_install

if TYPE_CHECKING:
    from PIL.Image import Image

FONT = "DejaVuSansMono"
_FAMILY = "'DejaVu Sans Mono', Menlo, Consolas, monospace"


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A box in pixels from the top left corner; colours as ``#rrggbb``."""

    x: int
    y: int
    width: int
    height: int
    fill: str
    stroke: str
    radius: int = 0
    line: int = 1


@dataclass(frozen=True, slots=True)
class Text:
    """A line of text whose top left corner is at a place."""

    x: int
    y: int
    text: str
    size: int
    colour: str
    bold: bool = False


@dataclass(frozen=True, slots=True)
class Drawing:
    """Shapes on white, the later ones on top."""

    width: int
    height: int
    shapes: Sequence[Rectangle | Text]


def text_width(text: str, size: int) -> int:
    """The width of a text in pixels."""
    return len(text) * _advance(size)


def _advance(size: int) -> int:
    return round(0.602 * size)


def svg(drawing: Drawing) -> str:
    """The drawing as SVG."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{drawing.width}" height="{drawing.height}" '
        f'viewBox="0 0 {drawing.width} {drawing.height}" font-family={quoteattr(_FAMILY)}>'
    )
    white = f'<rect width="{drawing.width}" height="{drawing.height}" fill="#ffffff"/>'
    return "\n".join([head, white, *map(_element, drawing.shapes), "</svg>", ""])


def _element(shape: Rectangle | Text) -> str:
    if isinstance(shape, Rectangle):
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


def png(drawing: Drawing) -> bytes:
    """The drawing as PNG.

    Raises:
        EaiError: matplotlib, from which the font is, or Pillow, which comes with it, is not installed.
    """
    file = io.BytesIO()
    image_of(drawing).save(file, "PNG", optimize=False)
    return file.getvalue()


def image_of(drawing: Drawing) -> Image:
    """The drawing as an image of Pillow's, in RGB.

    Raises:
        EaiError: as of `png`.
    """
    try:
        import matplotlib as mpl
        from PIL import Image, ImageDraw, ImageFont
    except ImportError as error:
        raise EaiError(f"pictures as PNG need {error.name}: {how_to_install('plots')}") from error
    folder = Path(mpl.get_data_path()) / "fonts" / "ttf"
    fonts: dict[tuple[int, bool], Any] = {}
    image = Image.new("RGB", (drawing.width, drawing.height), "#ffffff")
    canvas = ImageDraw.Draw(image)
    for shape in drawing.shapes:
        if isinstance(shape, Rectangle):
            corners = (shape.x, shape.y, shape.x + shape.width - 1, shape.y + shape.height - 1)
            canvas.rounded_rectangle(corners, shape.radius, shape.fill, shape.stroke, shape.line)
            continue
        key = (shape.size, shape.bold)
        if key not in fonts:
            name = f"{FONT}{'-Bold' if shape.bold else ''}.ttf"
            fonts[key] = ImageFont.truetype(
                str(folder / name), shape.size, layout_engine=ImageFont.Layout.BASIC
            )
        canvas.text((shape.x, shape.y), shape.text, shape.colour, fonts[key])
    return image
