"""Write docs/tutorials/train.ipynb: the tutorial as a notebook with its Python blocks as cells.

python tools/notebook.py
"""

from __future__ import annotations

import json
import re
from pathlib import Path

PAGE = Path(__file__).parent.parent / "docs/tutorials/train.md"
BLOCK = re.compile(
    r"^```(?P<language>python|console)\n(?P<code>.*?)^```$(?:\n\s*^```text\n.*?^```$)?",
    re.MULTILINE | re.DOTALL,
)


def make_notebook(page: str) -> str:
    """Return a page as the JSON of a notebook, without outputs. Commands get a leading ``!``."""
    cells, end = list[dict[str, object]](), 0
    for match in BLOCK.finditer(page):
        cells.append(_make_cell("markdown", page[end : match.start()], len(cells)))
        code = match["code"]
        if match["language"] == "console":
            code = code.replace("$ pip", "%pip").replace("$ ", "!")
        cells.append(_make_cell("code", code, len(cells)))
        end = match.end()
    cells.append(_make_cell("markdown", page[end:], len(cells)))
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    written = {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(written, indent=1, ensure_ascii=False) + "\n"


def _make_cell(kind: str, text: str, number: int) -> dict[str, object]:
    cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.strip()}
    return cell | ({"execution_count": None, "outputs": []} if kind == "code" else {})


if __name__ == "__main__":
    PAGE.with_suffix(".ipynb").write_text(make_notebook(PAGE.read_text("utf-8")), "utf-8")
