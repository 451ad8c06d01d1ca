"""Records, scoring of many answers, rewards, rates with intervals, and tables of results with writers."""
