"""Errors, files, the data store, archives, and entry points. No module here depends on tasks."""
