"""Repair of plans by fewest edits: edits, conflicts of edited plans, and the search."""
