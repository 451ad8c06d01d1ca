"""What Inspect finds of us by entry point: the built-in models, the scorer, and a task for every suite."""

from eai.abilities.protocol import Ability
from eai.benchmarks.registry import registered
from eai.run.provider import BuiltInModel
from eai.run.tasks import published_task, verdict_scorer

TASKS = {
    f"{name}_{ability.value}": published_task(name, ability) for name in registered() for ability in Ability
}
"""The tasks by name; registering them is what making them does."""

__all__ = ["TASKS", "BuiltInModel", "verdict_scorer"]
