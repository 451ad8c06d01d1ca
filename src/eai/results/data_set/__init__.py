"""Figures of a data set: how many tasks, how long, about what (paper, Table 2)."""
