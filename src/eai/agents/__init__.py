"""Play tasks with agents: games, observations, environments, and a server for agents of other programs."""
