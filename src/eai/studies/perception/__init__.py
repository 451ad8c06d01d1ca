"""Perception: forms of scenes in questions, errors in perceived scenes, and tasks with such scenes."""
