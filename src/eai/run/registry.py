"""Our part of Inspect, found by entry point: the built-in models, scorers, metrics, a task for every suite.

An ability that is asked of files has one task, which ``-T domain=FILE`` names the file to.
"""

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import find_abilities
from eai.benchmarks.registry import registered
from eai.run import provider
from eai.run.acting import player
from eai.run.scorer import SCORERS, paper_metrics
from eai.run.tasks import register_suite_task

TASKS = {
    f"{name}_{ability}".lstrip("_"): register_suite_task(name, ability)
    for ability in find_abilities()
    for name in ([""] if declaration_of(ability).interaction.task_command else registered())
}
"""The tasks by name; registering them is what making them does."""

__all__ = ["SCORERS", "TASKS", "paper_metrics", "player", "provider"]
