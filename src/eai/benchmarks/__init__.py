"""Benchmarks, the registry in which they are found, and answers without a model: gold, copies, chance."""
