"""What Inspect finds of us by entry point: the built-in models, scorers, metrics, a task for every suite."""

from eai.abilities.protocol import registered_abilities
from eai.benchmark.registry import registered
from eai.run.provider import BuiltInModel
from eai.run.questions import published_questions, question_scorer
from eai.run.scorer import SCORERS, paper_metrics
from eai.run.tasks import published_task

TASKS = {
    f"{name}_{ability.value}": published_task(name, ability)
    for name in registered()
    for ability in registered_abilities()
}
"""The tasks by name; registering them is what making them does."""

QUESTIONS = {f"{name}_questions": published_questions(name) for name in registered()}
"""World-model questions about each benchmark, likewise."""

__all__ = ["QUESTIONS", "SCORERS", "TASKS", "BuiltInModel", "paper_metrics", "question_scorer"]
