"""Errors: errors of answers and their causes, sorted by the paper's taxonomy."""
