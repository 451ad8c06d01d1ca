"""Tasks: their goals, how goals are tested, how both are worded, and files of tasks."""
