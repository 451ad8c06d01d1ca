"""Subgoal decomposition: the model answers with a sequence of subgoals to execute (paper, section 3)."""
