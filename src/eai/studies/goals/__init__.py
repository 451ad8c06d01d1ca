"""Goals: conditions that models state rightly, miss or invent in goal interpretation."""
