"""Perception: how questions show the scene, and how errors in a perceived scene change results."""
