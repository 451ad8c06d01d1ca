"""Benchmarks: what each one declares, and how its tasks are opened."""
