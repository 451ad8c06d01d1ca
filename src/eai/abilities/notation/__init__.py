"""Notations of answers, one for each benchmark. Abilities read a notation, and built-in models write it."""
