"""Transition modeling: the model writes operators, for comparison with gold operators and for planning."""
