"""Benchmarks: what each one declares, and the wing of the reference package."""
