"""Inspect's entry point: registers the built-in models, scorers, metrics, and a task for every suite.

A suite is an ability in a benchmark. An ability whose benchmarks are files has one task, and
``-T domain=FILE`` names the file.
"""

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import find_ability_entry_points
from eai.benchmarks.registry import list_benchmarks
from eai.run import provider
from eai.run.acting import player
from eai.run.scorer import SCORERS, make_inspect_metric_of_paper_scores
from eai.run.tasks import register_suite_task

TASKS = {
    f"{name}_{ability}".lstrip("_"): register_suite_task(name, ability)
    for ability in find_ability_entry_points()
    for name in ([""] if get_declaration(ability).interaction.task_command else list_benchmarks())
}
"""Mapping from names to the Inspect tasks. Creating a task registers it with Inspect."""

__all__ = ["SCORERS", "TASKS", "make_inspect_metric_of_paper_scores", "player", "provider"]
