"""Repair: the fewest edits of steps that make failed answers right."""
