"""Difficulty and discrimination of tasks as test items, and runs that ask only as many tasks as needed.

Entry points: `items` (a study), `adaptive_runs` (`eai run --adaptive`) and `short_tests` (`--tasks short`).
Extra: `analysis`.
Page: docs/extensions/adaptive/README.md.
"""
