"""Planning on declared domains: the planner, its heuristic and search, landmarks, and repair of plans."""
