"""What goes wrong and why: the leaves of the paper's taxonomy."""
