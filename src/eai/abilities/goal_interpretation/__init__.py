"""Goal interpretation: an instruction is given, the answer is the goal in symbols (paper, section 3)."""
