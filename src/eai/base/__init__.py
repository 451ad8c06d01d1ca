"""Errors, files, the data store, archives, and entry points. Nothing here depends on tasks."""
