"""Records, the scoring of many answers, rewards, rates, intervals, and tables with their writers."""
