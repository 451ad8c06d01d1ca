"""Derive goals from demonstrations, for any benchmark, and analyze how people rate annotations of tasks.

A demonstration is a plan that the data set records for a task.

Entry points: `data annotate` (commands) and `annotations` (a study).
Extra: `plots`, for figures of ratings.
Page: docs/extensions/annotation/README.md.
"""
