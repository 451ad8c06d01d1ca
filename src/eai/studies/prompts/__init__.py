"""Prompts: how much results of models depend on the wording of questions."""
