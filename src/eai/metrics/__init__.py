"""From counts to rates, intervals, comparisons, and the paper's tables as data."""
