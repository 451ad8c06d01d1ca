"""Records of scored answers, rewards, rates with confidence intervals, and tables of results."""
