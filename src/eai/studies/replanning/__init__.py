"""Replanning: further attempts at failed tasks, with or without feedback on the failure."""
