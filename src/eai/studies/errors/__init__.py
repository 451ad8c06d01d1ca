"""Errors and their causes: the leaves of the paper's taxonomy."""
