"""Figures as files: the style of all plots, and writing a figure in every format."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from eai.errors import EaiError, how_to_install

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("svg", "png", "pdf")
_UNDATED: dict[str, dict[str, None]] = {
    "svg": {"Date": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""The metadata of a format on the day and the program, by format."""

_DOTS_PER_INCH = 150
_STYLE = "plots.mplstyle"
_TITLE = 0.2
"""The height of a title, in inches."""


@contextmanager
def styled() -> Iterator[None]:
    """Within it, figures are drawn and written in the style of all plots.

    Raises:
        EaiError: matplotlib is not installed.
    """
    try:
        import matplotlib as mpl
    except ImportError as error:
        raise EaiError(f"plots need matplotlib: {how_to_install('plots')}") from error
    style = resources.files("eai.results") / _STYLE
    with resources.as_file(style) as path, mpl.rc_context(fname=path):
        yield


def entitle(figure: Figure, title: str) -> None:
    """Say above a figure, and above what it says there of itself, what it is of; it grows by as much."""
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + _TITLE)
    say_above(figure, f"{title}\n{figure.get_suptitle()}".strip())


def say_above(figure: Figure, text: str) -> None:
    """Say something above a figure, from its left edge on, where there is the room of all of its width."""
    figure.suptitle(text, x=0.01, ha="left", fontsize=7.5)


def write(figure: Figure, path: Path) -> tuple[Path, ...]:
    """Write a figure as ``path``.svg, ``.png`` and ``.pdf``, without the date and the program's version.

    It is laid out once, for the picture of dots. No letters are joined: for joined ones a PDF embeds a second
    font, and a search of its text misses them.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if isinstance(text, Text) and hasattr(text, "set_fontfeatures"):
            text.set_fontfeatures(("-liga",))
    figure.dpi = _DOTS_PER_INCH
    canvas = FigureCanvasAgg(figure)
    canvas.print_png(_target(path, "png"), metadata=_UNDATED["png"])  # type: ignore[no-untyped-call]
    figure.set_layout_engine(None)
    for kind in ("svg", "pdf"):
        figure.savefig(_target(path, kind), metadata=_UNDATED[kind])
    return tuple(_target(path, kind) for kind in FORMATS)


def _target(path: Path, kind: str) -> Path:
    return path.with_name(f"{path.name}.{kind}")
