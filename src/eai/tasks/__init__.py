"""Tasks from files: lines of JSON, folders of PDDL, problems in BDDL; where a benchmark gets them from."""
