"""Prompts: how much results depend on the wording of questions."""
