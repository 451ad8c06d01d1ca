"""Tasks made by the engine, in the world of any benchmark: unseen by anybody, and each with a plan."""
