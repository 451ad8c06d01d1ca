"""Acting: a task is played one action at a time, and the episode is scored as other answers are."""
