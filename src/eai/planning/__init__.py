"""The planner on declared domains: agenda, best-first search, heuristic, achievers, preferred operators."""
