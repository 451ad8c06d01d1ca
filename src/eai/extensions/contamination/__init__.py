"""Compares success on public tasks with success on generated tasks; opens benchmarks with swapped names.

Entry points: `contamination` (a study); `obfuscated`, which opens the tasks of a benchmark with swapped
names, and `rules`, which opens them with the true names. In both, the prompts state the exact rules of
all actions, which the benchmark's own prompts leave out.
Extra: none.
Page: docs/extensions/contamination/README.md.
"""
