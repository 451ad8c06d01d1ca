"""Tasks: the goals of tasks, tests of plans for goals, the words for tasks in prompts, and files of tasks."""
