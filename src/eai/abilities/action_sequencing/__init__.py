"""Action sequencing: given an initial state and a goal, the model answers with a plan (paper, section 3)."""
