"""Errors: failed answers and the causes of failures, sorted by the paper's taxonomy."""
