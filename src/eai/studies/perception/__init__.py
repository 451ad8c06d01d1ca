"""Perception: how questions show scenes, errors in the perceived scene, and tasks as they are perceived."""
