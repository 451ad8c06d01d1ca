"""An analysis that compares answers to public tasks with answers to generated tasks of the same world.

Entry point: `contamination` (a study).
Extra: none.
Page: docs/extensions/contamination/README.md.
"""
