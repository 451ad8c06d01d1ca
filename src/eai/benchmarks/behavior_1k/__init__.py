"""BEHAVIOR-1K: a symbolic model of a thousand household activities."""
