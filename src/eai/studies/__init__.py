"""Studies: variations around a benchmark and an ability, one folder each, with what they compute and draw."""
