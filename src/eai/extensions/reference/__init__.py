"""The protocol `eai-1.0.5`: the verdicts of release 1.0.5 of the paper's package, including its defects.

That package is called eai-eval. Names in this folder call its defects quirks.

Entry point: `eai-1.0.5` (a protocol).
Extra: none.
Page: docs/extensions/reference/README.md.
"""
