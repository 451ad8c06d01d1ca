"""BEHAVIOR-1K: a symbolic reading of a thousand household activities."""
