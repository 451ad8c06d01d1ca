"""Repair: the distance of failed answers from right ones, and the edits that make them right."""
