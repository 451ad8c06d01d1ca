"""Transition modeling: the model writes operators, which are compared with gold ones and used to plan."""
