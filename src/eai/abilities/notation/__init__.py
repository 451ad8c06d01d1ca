"""Notations of answers. Each benchmark has one: abilities read it, built-in models write it."""
