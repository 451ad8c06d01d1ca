"""Tasks: the goals of tasks, tests of plans for goals, texts about tasks in prompts, and files of tasks."""
