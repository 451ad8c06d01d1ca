"""Prompts for the paper's four abilities (kinds of questions): published prompts, and our own."""
