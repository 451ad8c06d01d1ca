"""Perception: what is seen of a scene, how wrong that is, what is believed then, and pictures of it."""
