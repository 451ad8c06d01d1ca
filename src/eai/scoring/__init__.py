"""Many answers scored: records and summaries, in one process or several."""
