"""Pipelines: the answer of one ability is the input of the next."""
