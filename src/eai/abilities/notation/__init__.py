"""How answers are written, as a benchmark has it: what the abilities read, and built-in models write."""
