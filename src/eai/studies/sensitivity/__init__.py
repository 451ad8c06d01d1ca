"""Sensitivity: which operators of a model's answers make planning fail."""
