"""Generate new tasks in a benchmark's world. Each task has a plan that solves it."""
