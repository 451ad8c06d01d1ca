"""An analysis of a model's conduct: whether plans avoid hazards, and whether impossible tasks are refused.

Entry point: `conduct` (a study).
Extra: none.
Page: docs/extensions/conduct/README.md.
"""
