"""Prompts for the four abilities: those published with the data set, and our own."""
