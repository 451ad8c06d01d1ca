"""The protocol `eai-1.0.5`: verdicts of the paper's reference package, release 1.0.5, defect by defect.

Entry point: `eai-1.0.5` (a protocol).
Extra: none.
Page: docs/extensions/reference/README.md.
"""
