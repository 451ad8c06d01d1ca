"""Repair of plans by fewest edits: the edits, the conflicts of edited plans, and the search for repairs."""
