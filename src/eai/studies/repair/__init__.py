"""Repair: the fewest steps to insert, delete or replace that make a failed answer right."""
