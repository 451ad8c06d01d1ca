"""The files of scene graphs: each with its errors, and the rates of all of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from eai.abilities.codec import dataclass_to_json
from eai.abilities.record import Perceived
from eai.abilities.verdict import Json, add, confusion_shares
from eai.data.files import write_whole
from eai.results.perceived import perception_shares
from eai.results.rate import NOTHING, Rate, total
from eai.studies.perception.scene_graph import ReadGraph

SCENE_GRAPHS = "scene_graphs.jsonl"


def write_scene_graphs(
    folder: Path, model: str, domain: str, read: Mapping[str, ReadGraph], errors: Mapping[str, Perceived]
) -> None:
    """Write scene graphs with their errors, one a line, and the rates of all of them.

    Raises:
        InputError: the folder cannot be written.
    """
    lines = [
        {
            "task_id": task_id,
            "scene_graph": json.loads(each.graph.text),
            "ill_formed": list(each.ill_formed),
            "repairs": list(each.repairs),
            "perceived": dataclass_to_json(errors[task_id]),
        }
        for task_id, each in read.items()
    ]
    rates: dict[str, Json] = {name: rate.to_json() for name, rate in rates_of(errors).items()}
    summary = {"domain": domain, "model": model, "scenes": len(lines), "unit": "percent", **rates}
    texts = (json.dumps(line) + "\n" for line in lines)
    write_whole({folder / SCENE_GRAPHS: texts, folder / "summary.json": json.dumps(summary, indent=2) + "\n"})


def rates_of(errors: Mapping[str, Perceived]) -> dict[str, Rate]:
    """The rates of all scene graphs, then precision, recall and F1 of each predicate."""
    found = list(errors.values())
    names = sorted({name for each in found for name in each.predicates})
    by_predicate = [
        confusion_shares(name, add([each.predicates[name] for each in found if name in each.predicates]))
        for name in names
    ]
    return total([*map(perception_shares, found), *by_predicate])


def in_words(errors: Mapping[str, Perceived]) -> str:
    """The paper's two rates, precision and recall, for a line on a screen."""
    rates = rates_of(errors)
    shown = {
        "predicate errors": "predicate_error",
        "object errors": "object_error",
        "precision": "facts.precision",
        "recall": "facts.recall",
    }
    parts = []
    for title, name in shown.items():
        rate = rates.get(name, NOTHING)
        value = "-" if rate.percent is None else f"{rate.percent:.1f} %"
        parts.append(f"{title} {value} ({rate.numerator:g}/{rate.denominator:g})")
    return ", ".join(parts)
