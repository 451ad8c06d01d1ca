"""Fits how difficult tasks are expected to be by plan and goals: `python tools/task_difficulty.py`.

A ridge regression of the public tasks' difficulties in action sequencing, written to ``difficulty.json`` of
``eai.benchmarks``. R squared, rank correlation and error are those of each title by the others alone,
as tasks of one title are near copies.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from eai.abilities.protocol import Ability
from eai.benchmarks.generator.measures import FEATURES, FILE, features_of
from eai.benchmarks.registry import FIRST, find_benchmark
from eai.extensions.adaptive.difficulties import item_difficulties
from eai.tasks.source import Source

PATH = Path(__file__).resolve().parents[1] / "src" / "eai" / "benchmarks" / "generator" / FILE
RIDGE = 5.0


def main() -> None:
    models = {name: fitted(name) for name in FIRST}
    PATH.write_text(json.dumps(models, indent=1) + "\n", encoding="utf-8")
    for name, model in models.items():
        print(name, dict(zip(FEATURES, model["weights"], strict=True)), model)


def fitted(name: str) -> dict[str, Any]:
    """The model of a household, and how well it foretells titles that it has not seen."""
    tasks = find_benchmark(name).tasks(Source())
    known = item_difficulties(name, Ability.ACTION_SEQUENCING)
    planned = [task_id for task_id in known if tasks[task_id].script]
    features = np.array([features_of(tasks[task_id]) for task_id in planned])
    difficulties = np.array([known[task_id] for task_id in planned])
    titles = np.array([tasks[task_id].title for task_id in planned])
    foretold, mean = np.zeros(len(planned)), np.zeros(len(planned))
    for title in sorted(set(titles)):
        out = titles == title
        intercept, weights = _fit(features[~out], difficulties[~out])
        foretold[out] = intercept + features[out] @ weights
        mean[out] = difficulties[~out].mean()
    squared = float(((difficulties - foretold) ** 2).sum())
    intercept, weights = _fit(features, difficulties)
    return {
        "intercept": round(intercept, 3),
        "weights": [round(float(weight), 3) for weight in weights],
        "error": round((squared / len(planned)) ** 0.5, 2),
        "r_squared": round(1 - squared / float(((difficulties - mean) ** 2).sum()), 2),
        "rank_correlation": round(float(spearmanr(difficulties, foretold)[0]), 2),
    }


def _fit(features: Any, difficulties: Any) -> tuple[float, Sequence[float]]:
    """Intercept and weights; the penalty is on features of standard deviation one."""
    mean, spread = features.mean(axis=0), features.std(axis=0)
    scaled = (features - mean) / spread
    inner = scaled.T @ scaled + RIDGE * np.eye(scaled.shape[1])
    weights = np.linalg.solve(inner, scaled.T @ (difficulties - difficulties.mean())) / spread
    return float(difficulties.mean() - mean @ weights), weights


if __name__ == "__main__":
    main()
