"""Pipelines: questions of one ability, such as planning, state goals that a model gave in earlier answers."""
