"""Heat maps of prompts and models, one a model, with the prompts in that model's order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eai.results.plots import INK, clipped, value_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.results.table import Table

_COLUMN, _ROW = 0.62, 0.24
_MARGIN = (1.7, 1.35)
_PANELS = 3
_PALE = 0.55
"""Above this share of the range a field is dark enough for white letters."""


def draw(table: Table, metric: str, title: str) -> Figure:
    """Draw the heat maps of a suite from the table of its cells."""
    from matplotlib.figure import Figure

    rows_of = {(str(row["prompt"]), str(row["answered_by"])): row for row in table.by_name()}
    cells = {place: value_of(row["value"]) for place, row in rows_of.items()}
    prompts, models = (list(dict.fromkeys(names)) for names in zip(*cells, strict=True))
    columns = min(_PANELS, len(models))
    rows = -(-len(models) // columns)
    width = columns * (_MARGIN[0] + _COLUMN * len(models)) + 0.6
    height = rows * (_MARGIN[1] + _ROW * len(prompts)) + 0.3
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    grid = figure.subplots(rows, columns, squeeze=False).flatten()
    low, high = min(cells.values()), max(cells.values())
    image = None
    for panel, model in zip(grid, models, strict=False):
        order = sorted(prompts, key=lambda prompt, model=model: -cells[prompt, model])  # type: ignore[misc]
        values = [[cells[prompt, each] for each in models] for prompt in order]
        image = panel.imshow(values, cmap="Blues", vmin=low, vmax=high + 1e-9, aspect="auto")
        panel.set_title(f"by {clipped(model)}")
        labels = [clipped(each) for each in models]
        panel.set_xticks(range(len(models)), labels=labels, rotation=40, ha="right", fontsize=6.5)
        panel.set_yticks(range(len(order)), labels=[clipped(each) for each in order], fontsize=7)
        panel.tick_params(length=0)
        panel.spines[:].set_visible(False)
        for y, row in enumerate(values):
            for x, value in enumerate(row):
                dark = high > low and (value - low) / (high - low) > _PALE
                panel.text(
                    x,
                    y,
                    f"{value:.1f}",
                    ha="center",
                    va="center",
                    fontsize=6.5,
                    color="white" if dark else INK,
                )
    for panel in grid[len(models) :]:
        panel.set_visible(False)
    if image is not None:
        figure.colorbar(image, ax=list(grid), label=f"{metric}, percent", shrink=0.8)
    return figure
