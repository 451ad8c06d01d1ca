"""Benchmarks: their registry, suites, errata, baselines such as random answers, and the task generator."""
