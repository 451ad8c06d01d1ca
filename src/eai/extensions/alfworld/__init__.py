"""ALFWorld's text games as benchmarks, found by references such as `alfworld:FOLDER`.

Entry point: `alfworld` (opens such references).
Extra: none; the games bring their own package.
Page: docs/extensions/alfworld/README.md.
"""
