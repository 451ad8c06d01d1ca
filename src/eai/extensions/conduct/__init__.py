"""Conduct: whether plans avoid the hazards on their way, and whether what is impossible is refused."""
