"""Studies: each varies the options of runs, or analyses the records of runs with tables and figures.

Each study has its own folder.
"""
