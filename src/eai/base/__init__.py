"""Errors, files, the data store, archives, and entry points: nothing here knows of tasks."""
