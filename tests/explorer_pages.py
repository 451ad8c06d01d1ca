"""Reads the data in a page of the explorer, as the program in the page does."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any


def read_chunks(page: str) -> list[Any]:
    """Return the chunks of data in a page; the last chunk is the index."""
    lines = page.partition('id="data">')[2].partition("</script>")[0].split()
    return [json.loads(zlib.decompress(base64.b64decode(line, validate=True))) for line in lines]


def read_explorer(page: str) -> dict[str, Any]:
    """Return the index of a page, with the runs in order, all fields of their answers, and whole prompts."""
    chunks = read_chunks(page)
    index: dict[str, Any] = chunks.pop()
    answers: list[list[dict[str, Any]]] = [[] for _ in index["runs"]]
    for listed, details in zip(index["chunks"], chunks, strict=False):
        columns = {**listed, **details["columns"]}
        for values in zip(*columns.values(), strict=True):
            row = {name: value for name, value in zip(columns, values, strict=True) if value is not None}
            answers[row["run"]].append({**row, "chunk": details})
    index["runs"] = [{**index["runs"][place], "answers": answers[place]} for place in index["order"]]
    for suite, number in index["prompts"].items():
        lines = chunks[number]["lines"]
        index["prompts"][suite] = {
            task: "\n".join(lines[line] for line in numbers)
            for task, numbers in chunks[number]["tasks"].items()
        }
    return index
