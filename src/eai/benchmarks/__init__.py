"""Benchmarks, their registry, suites and errata, baselines such as random answers, and the task generator."""
