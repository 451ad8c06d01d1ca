"""Repair of plans by fewest edits: the edits, causes of failure (conflicts), and the search for repairs."""
