"""PDDL: reading and writing, matching operators, calling planners."""
