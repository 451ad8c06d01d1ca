"""Benchmarks: registry, suites, errata, null models; VirtualHome, BEHAVIOR, BEHAVIOR-1K; the generator."""
