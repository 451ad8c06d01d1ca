"""What success depends on: correlations and regressions over tasks and models."""
