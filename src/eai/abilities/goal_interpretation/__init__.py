"""Goal interpretation: given an instruction, the model states the goal in symbols (paper, section 3)."""
