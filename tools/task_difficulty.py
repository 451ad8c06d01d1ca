"""Fit the expected difficulty of tasks to features of plan and goals: `python tools/task_difficulty.py`.

The model is a ridge regression on the public tasks' difficulties in action sequencing. It is written to
``difficulty.json`` of ``eai.benchmarks``. R squared, rank correlation and error come from cross-validation by
title, because tasks of one title are near copies.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from eai.abilities.protocol import Ability
from eai.benchmarks.generator.measures import FEATURES, FILE, compute_difficulty_features
from eai.benchmarks.registry import PAPER_BENCHMARKS, find_benchmark
from eai.extensions.adaptive.difficulties import load_task_difficulties
from eai.tasks.source import Source

PATH = Path(__file__).resolve().parents[1] / "src" / "eai" / "benchmarks" / "generator" / FILE
RIDGE = 5.0


def main() -> None:
    models = {name: fit(name) for name in PAPER_BENCHMARKS}
    PATH.write_text(json.dumps(models, indent=1) + "\n", encoding="utf-8")
    for name, model in models.items():
        print(name, dict(zip(FEATURES, model["weights"], strict=True)), model)


def fit(name: str) -> dict[str, Any]:
    """Return the model of a benchmark, with its cross-validated R squared, rank correlation and error."""
    tasks = find_benchmark(name).tasks(Source())
    difficulty_of = load_task_difficulties(name, Ability.ACTION_SEQUENCING)
    planned = [task_id for task_id in difficulty_of if tasks[task_id].script]
    features = np.array([compute_difficulty_features(tasks[task_id]) for task_id in planned])
    difficulties = np.array([difficulty_of[task_id] for task_id in planned])
    titles = np.array([tasks[task_id].title for task_id in planned])
    predicted, mean = np.zeros(len(planned)), np.zeros(len(planned))
    for title in sorted(set(titles)):
        out = titles == title
        intercept, weights = _fit(features[~out], difficulties[~out])
        predicted[out] = intercept + features[out] @ weights
        mean[out] = difficulties[~out].mean()
    squared = float(((difficulties - predicted) ** 2).sum())
    intercept, weights = _fit(features, difficulties)
    return {
        "intercept": round(intercept, 3),
        "weights": [round(float(weight), 3) for weight in weights],
        "error": round((squared / len(planned)) ** 0.5, 2),
        "r_squared": round(1 - squared / float(((difficulties - mean) ** 2).sum()), 2),
        "rank_correlation": round(float(spearmanr(difficulties, predicted)[0]), 2),
    }


def _fit(features: Any, difficulties: Any) -> tuple[float, Sequence[float]]:
    """Return intercept and weights. The penalty applies to features scaled to standard deviation 1."""
    mean, spread = features.mean(axis=0), features.std(axis=0)
    scaled = (features - mean) / spread
    inner = scaled.T @ scaled + RIDGE * np.eye(scaled.shape[1])
    weights = np.linalg.solve(inner, scaled.T @ (difficulties - difficulties.mean())) / spread
    return float(difficulties.mean() - mean @ weights), weights


if __name__ == "__main__":
    main()
