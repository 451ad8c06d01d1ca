"""The data set: getting it, its compact store, and task records."""
