"""Repair plans by fewest edits: edits of plans, conflicts of edited plans, and the search for repairs."""
