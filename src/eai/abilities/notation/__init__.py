"""Notations of answers, which a benchmark chooses: abilities read them, built-in models write them."""
