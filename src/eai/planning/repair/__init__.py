"""Repair of plans by fewest edits: edits, first failures of plans (conflicts), the search for repairs."""
