"""Generate new tasks with the domain and scenes of a benchmark, and a plan that solves each task."""
