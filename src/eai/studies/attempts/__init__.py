"""Replanning: further attempts, with feedback or without."""
