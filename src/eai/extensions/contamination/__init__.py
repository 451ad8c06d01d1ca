"""Public tasks beside generated ones of the same world."""
