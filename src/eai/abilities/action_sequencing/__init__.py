"""Action sequencing: an initial state and a goal are given, the answer is a plan (paper, section 3)."""
