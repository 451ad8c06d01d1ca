"""Repair: the smallest edits that make failed answers right, and their number."""
