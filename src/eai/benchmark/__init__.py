"""What a benchmark is, where it is found, and who answers without a model: gold, copies, chance."""
