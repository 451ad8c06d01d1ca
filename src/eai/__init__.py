"""Measure, diagnose and train language models for embodied decision making."""

__version__ = "0.1.0"
