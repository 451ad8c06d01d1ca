"""Tasks as items of a test: difficulty, discrimination, and runs that ask only as many tasks as they need.

Entry points: `items` (a study) and `adaptive_runs` (`eai run --adaptive`).
Extra: `analysis`.
Page: docs/extensions/adaptive/README.md.
"""
