"""Generated tasks in a benchmark's world. Nobody has seen them before, and each has a plan that solves it."""
