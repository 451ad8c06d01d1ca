"""Pipelines: what one ability answers is what the next is told."""
