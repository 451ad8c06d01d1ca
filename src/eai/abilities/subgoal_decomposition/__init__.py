"""Subgoal decomposition: the model answers with a sequence of subgoals, to be executed (paper, section 3)."""
