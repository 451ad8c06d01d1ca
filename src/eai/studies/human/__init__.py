"""People who answer the questions of a benchmark as models do."""
