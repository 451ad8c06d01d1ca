"""Compares success on public tasks with success on generated tasks; opens benchmarks with swapped names.

Entry points: `contamination` (a study); `obfuscated`, which opens the tasks of a benchmark with swapped names
and exact rules, and `rules`, which opens them with the true names and exact rules.
Extra: none.
Page: docs/extensions/contamination/README.md.
"""
