"""Sensitivity: the operators of a model that break plans."""
