"""The planner on a declared domain: agenda, best-first search, heuristic, achievers, preferred operators."""
