"""Tasks as items of a test: difficulty, discrimination, and runs that ask only as many tasks as they need.

Entry points: `items` (a study), `adaptive_runs` (`eai run --adaptive`) and `short_tests` (`--tasks short`).
Extra: `analysis`.
Page: docs/extensions/adaptive/README.md.
"""
