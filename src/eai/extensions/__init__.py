"""Extensions: each folder adds something that the rest of eai does not know; entry points find it."""
