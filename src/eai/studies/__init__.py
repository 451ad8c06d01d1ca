"""Studies: each varies the options of runs, or analyses their records (the stored verdicts on answers).

Each study has its own folder.
"""
