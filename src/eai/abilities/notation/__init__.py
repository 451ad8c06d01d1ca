"""Notations of answers, one for each benchmark: how models write answers, and how scorers read them."""
