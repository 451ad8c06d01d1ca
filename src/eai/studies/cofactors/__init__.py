"""Cofactors of success: correlations and regressions over tasks and models."""
