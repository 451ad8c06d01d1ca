"""Readers of logs of other projects, and an analysis of the episodes in these logs.

Entry points: `logs` (a study, and functions for `eai score` and `eai explain`), and `eai-v2`,
`alfworld-runs`, `embodiedbench` and `inspect` (readers of logs).
Extra: none.
Page: docs/extensions/logs/README.md.
"""
