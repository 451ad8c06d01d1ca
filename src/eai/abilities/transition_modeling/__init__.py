"""Transition modeling: the answer is a set of operators, compared with the gold ones and used to plan."""
