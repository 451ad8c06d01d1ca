"""Pipelines: questions of one ability, such as planning, state a model's answers to another: its goals."""
