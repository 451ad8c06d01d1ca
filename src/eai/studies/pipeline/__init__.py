"""Pipelines: questions, such as questions for a plan, contain goals from earlier answers of a model."""
