"""Subgoal decomposition: the answer is a sequence of subgoals, which is carried out (paper, section 3)."""
