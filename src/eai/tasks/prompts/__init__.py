"""Prompts for the four abilities, official and our own."""
