"""Compares public tasks with generated tasks of the same world; opens benchmarks with swapped names.

Entry points: `contamination` (a study); `obfuscated` and `rules`, which open the same tasks in swapped words
and in plain words with exact rules.
Extra: none.
Page: docs/extensions/contamination/README.md.
"""
