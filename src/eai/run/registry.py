"""What Inspect finds of us by entry point: the built-in models and the tasks."""

from eai.run.provider import BuiltInModel
from eai.run.tasks import verdict_scorer, virtualhome_action_sequencing

__all__ = ["BuiltInModel", "verdict_scorer", "virtualhome_action_sequencing"]
