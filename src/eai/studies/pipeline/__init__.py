"""Pipelines: a model's answer to one ability is the input of the next ability."""
