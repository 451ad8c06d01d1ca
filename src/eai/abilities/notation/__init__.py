"""Notations of answers, one for each benchmark: how answers are written by models and read by abilities."""
