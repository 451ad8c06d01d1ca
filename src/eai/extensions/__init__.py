"""Extensions: each folder adds something that the rest does not know, and is found by its entry points."""
