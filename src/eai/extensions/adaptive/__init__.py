"""Tasks as items of a test: difficulty, discrimination, short and adaptive tests."""
