"""Modules that know nothing of tasks: errors, files, the data store, archives and entry points."""
