"""Pipelines of questions: a question for a plan states the goals that the model gave in an earlier answer."""
