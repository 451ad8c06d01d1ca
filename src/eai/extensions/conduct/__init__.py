"""An analysis of a model's conduct: whether plans avoid hazards, and whether impossible tasks are refused.

A hazard is an event that must not happen during a task.

Entry point: `conduct` (a study).
Extra: none.
Page: docs/extensions/conduct/README.md.
"""
