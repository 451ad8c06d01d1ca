"""The fewest edits that make a plan succeed: edits, conflicts of edited plans, and the search."""
